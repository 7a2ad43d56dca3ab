"""The summary of a flight, as frozen records and as plain data for --json.

All times are simulation time in [ns]; in the plain data in [s]. `summary_builder` makes it from the flight's messages.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

from waypointctl.log.header import MissionSetting, Span
from waypointctl.log.messages import DeliveryOutcome, Event, EventKind, PlannedWaypoint
from waypointctl.replay.command_summary import CommandSummary
from waypointctl.replay.legs import ReturnEnding, ReturnHome, WaypointStatus, WaypointSummary
from waypointctl.replay.link_summary import LinkDirectionSummary, LinkSummary
from waypointctl.replay.track import Effort, Track
from waypointctl.units import seconds

UNFINISHED: Final = "unfinished"  # outcome of a log without an end
NEVER_NS: Final = 1 << 62


@dataclass(frozen=True, slots=True, eq=False)
class FlightSummary:
    """A flight."""

    outcome: str  # "success", "failure" or "interrupted"; "unfinished" for a log without an end
    reason: str  # why, in a few words
    ended_ns: int  # when the mission ended on the operator's clock, or the last time there is
    steps: int  # control steps flown
    waypoints: tuple[WaypointSummary, ...]  # of the mission, in order
    places: tuple[PlannedWaypoint, ...]  # where else the robot was commanded to go, as it arrived, each once
    commands: tuple[CommandSummary, ...]  # by id
    events: tuple[Event, ...]  # in the order they happened
    reward: tuple[tuple[str, float], ...]  # each term's sum over the flight
    reward_total: float  # the sum of the rewards of all steps
    effort: Effort  # distance and time
    moving: tuple[Span, ...]  # when the robot moved by a policy's actions, on board or from the ground
    resting: tuple[Span, ...]  # when it stood so still that physics slept
    returns: tuple[ReturnHome, ...]  # each return home that began
    truth: Track  # where the robot was
    belief: Track  # where telemetry reported the robot
    states_off_map: int  # how many states `truth` and `effort` leave out, as no robot can be there
    frames_off_map: int  # how many telemetry frames `belief` leaves out
    link: LinkSummary  # losses, duplicates and waits
    setting: MissionSetting  # what the mission has fixed beforehand: home, zones, contact windows

    @property
    def reached(self) -> int:
        """How many waypoints the robot reached."""
        return sum(waypoint.status is WaypointStatus.REACHED for waypoint in self.waypoints)

    @property
    def known(self) -> int:
        """How many of them the operator knows to be reached."""
        return sum(waypoint.known_ns is not None for waypoint in self.waypoints)

    @property
    def has_end(self) -> bool:
        """Whether the flight came to its end, whatever the outcome: it was not killed."""
        return self.outcome != UNFINISHED

    @property
    def ending(self) -> str:
        """The outcome and why, as the operator knows it."""
        return f"{self.outcome}: {self.reason}" if self.reason else self.outcome

    @property
    def headline(self) -> str:
        """The outcome as the operator knows it; where the robot reached more waypoints than is known, both counts."""
        if not self.has_end or self.reached == self.known:
            return self.ending
        return f"{self.ending}; the robot reached {self.reached}, the operator knows of {self.known}"

    @property
    def ended_at(self) -> Track:
        """Where the robot was in the end: one row, or none of a flight without a state."""
        return self.truth.last()

    @property
    def believed_at(self) -> Track:
        """What the operator knew of that in the end: the frame that was sampled last, or none."""
        return self.belief.newest().last()

    @property
    def home(self) -> PlannedWaypoint | None:
        """Home, where it matters."""
        return self.setting.home_to_show(has_returned=bool(self.returns))

    @property
    def home_distance_m(self) -> float | None:
        """How far from home the robot ended; None where there is no home that matters, or no state."""
        if self.home is None or not len(self.ended_at):
            return None
        return math.dist((self.home.x_m, self.home.y_m), (self.ended_at.x_m[0], self.ended_at.y_m[0]))

    @property
    def falls(self) -> int:
        """How often the robot fell."""
        return sum(event.kind is EventKind.FALL for event in self.events)

    @property
    def had_console(self) -> bool:
        """Whether a person could command too."""
        return any(event.kind is EventKind.CONSOLE_OPENED for event in self.events)

    @property
    def interrupted_ns(self) -> int:
        """When a user ended the flight; NEVER_NS for a flight that was not interrupted."""
        return self.ended_ns if self.outcome == "interrupted" else NEVER_NS


Plain = dict[str, object]


def summary_json(summary: FlightSummary, mission: str) -> Plain:
    """Return the summary; times in [s] from mission start, None for what never came.

    Of a command, `issued_s` is its first sending, `uplink_s` is of the sending that arrived first, and `round_trip_s`
    of the sending that the first acknowledgement answers.
    """
    effort, link = summary.effort, summary.link
    return {
        "mission": mission,
        "outcome": summary.outcome,
        "reason": summary.reason,
        **_times(summary, "ended"),
        "control_steps": summary.steps,
        "waypoints_reached": summary.reached,
        "waypoints_known": summary.known,
        "waypoints_total": len(summary.waypoints),
        "falls": summary.falls,
        "distance_m": effort.distance_m,
        "mean_speed_mps": effort.mean_speed_mps,
        **_times(effort, "moving", "stopped", "fallen"),
        "stopped_share": effort.stopped_share,
        "reward": dict(summary.reward),
        "reward_total": summary.reward_total,
        "states_off_map": summary.states_off_map,
        "frames_off_map": summary.frames_off_map,
        "home": None if summary.home is None else {"x_m": summary.home.x_m, "y_m": summary.home.y_m},
        "returns_home": [_return(each) for each in summary.returns],
        "ended_at": _place(summary.ended_at),
        "believed_at": _place(summary.believed_at),
        "home_distance_m": summary.home_distance_m,
        "waypoints": [_waypoint(waypoint) for waypoint in summary.waypoints],
        "commands": [_command(command) for command in summary.commands],
        "link": {
            "up": _direction(link.up),
            "down": _direction(link.down),
            "lost_on_board": [{"from_s": seconds(begin), "to_s": seconds(end)} for begin, end in link.lost_spans],
        },
    }


def _times(record: object, *names: str) -> Plain:
    """Return times of a record in [s], such as "began_s" of `began_ns`."""
    times_ns = ((name, getattr(record, f"{name}_ns")) for name in names)
    return {f"{name}_s": None if time_ns is None else seconds(time_ns) for name, time_ns in times_ns}


def _return(each: ReturnHome) -> Plain:
    return {
        "cause": each.cause,
        "command": each.command_id,
        **_times(each, "began", "began_known"),
        "ending": str(each.ending),
        "reached": each.ending is ReturnEnding.REACHED,
        **_times(each, "ended", "ended_known"),
    }


def _place(track: Track) -> Plain | None:
    """Return the place in a track's only row, and when the robot was there; None of one without a row."""
    if not len(track):
        return None
    return {"x_m": float(track.x_m[0]), "y_m": float(track.y_m[0]), "at_s": seconds(int(track.time_ns[0]))}


def _direction(it: LinkDirectionSummary) -> Plain:
    return {
        "lost": it.count(DeliveryOutcome.LOST),
        "queue_full": it.count(DeliveryOutcome.QUEUE_FULL),
        "no_contact": it.count(DeliveryOutcome.NO_CONTACT),
        "not_arrived": it.not_arrived,
        "duplicated": it.count(DeliveryOutcome.DUPLICATED),
        "waited": it.waited,
        **_times(it, "longest_wait"),
    }


def _waypoint(waypoint: WaypointSummary) -> Plain:
    plan = waypoint.planned
    return {
        "name": plan.name,
        "x_m": plan.x_m,
        "y_m": plan.y_m,
        "acceptance": plan.acceptance,
        "tolerance_m": plan.tolerance_m,
        "status": str(waypoint.status),
        **_times(waypoint, "started", "ended", "reached", "known"),
    }


def _command(command: CommandSummary) -> Plain:
    return {
        "id": command.id,
        "command": command.description,
        **_times(command, "issued", "received", "acknowledged", "ended", "end_known"),
        **_times(command, "uplink", "downlink", "round_trip"),
        "known_stage": str(command.known_stage),
        "on_board": None if command.onboard is None else str(command.onboard),
        "attempts": command.attempts,
        "losses": command.losses,
    }
