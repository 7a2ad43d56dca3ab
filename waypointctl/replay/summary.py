"""The summary of a flight, as frozen records: what was commanded, what was reached, how the robot moved.

All times are simulation time in [ns]. `summary_builder` makes it from the flight's messages.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from waypointctl.log.messages import Event, EventKind, PlannedWaypoint
from waypointctl.log.setting import MissionSetting, Span
from waypointctl.replay.command_summary import CommandSummary
from waypointctl.replay.effort import Effort
from waypointctl.replay.link_summary import LinkSummary
from waypointctl.replay.return_home import ReturnHome
from waypointctl.replay.track import Track, is_on_map

UNFINISHED: Final = "unfinished"  # outcome of a log without an end
NEVER_NS: Final = 1 << 62


class WaypointStatus(StrEnum):
    """Whether a waypoint was reached, and why not."""

    REACHED = "reached"
    TIMED_OUT = "timed out"
    SKIPPED = "skipped"
    OPEN = "not reached"


@dataclass(frozen=True, slots=True)
class WaypointSummary:
    """A waypoint, and whether it was reached.

    Attributes:
        planned: as it was, or would have been, commanded.
        status: as the robot knows it.
        started_ns: when the robot's leg to it began, None if it never did.
        ended_ns: when it was reached or given up, None for a leg that was under way to the end.
        reached_ns: on the robot's clock.
        known_ns: when the operator learned that it was reached.
    """

    planned: PlannedWaypoint
    status: WaypointStatus = WaypointStatus.OPEN
    started_ns: int | None = None
    ended_ns: int | None = None
    reached_ns: int | None = None
    known_ns: int | None = None

    @property
    def is_on_map(self) -> bool:
        """Whether it can be drawn."""
        return is_on_map(self.planned.x_m, self.planned.y_m, self.planned.tolerance_m)


@dataclass(frozen=True, slots=True, eq=False)
class FlightSummary:
    """A flight.

    Attributes:
        outcome: "success", "failure" or "interrupted"; "unfinished" for a log without an end.
        reason: why, in a few words.
        ended_ns: when the mission ended on the operator's clock, or the last time there is.
        steps: control steps flown.
        waypoints: of the mission, in order.
        places: where else the robot was commanded to go, as it arrived, each once.
        commands: by id.
        events: in the order they happened.
        reward: each term's sum over the flight.
        reward_total: the sum of the rewards of all steps.
        effort: distance and time.
        moving: when the robot moved by a policy's actions, on board or from the ground.
        resting: when it stood so still that physics slept.
        returns: each return home that began.
        truth: where the robot was.
        belief: where telemetry reported the robot.
        states_off_map: how many states `truth` and `effort` leave out, as no robot can be there.
        frames_off_map: how many telemetry frames `belief` leaves out.
        link: losses, duplicates and waits.
        setting: what the mission has fixed beforehand: home, zones, contact windows.
    """

    outcome: str
    reason: str
    ended_ns: int
    steps: int
    waypoints: tuple[WaypointSummary, ...]
    places: tuple[PlannedWaypoint, ...]
    commands: tuple[CommandSummary, ...]
    events: tuple[Event, ...]
    reward: tuple[tuple[str, float], ...]
    reward_total: float
    effort: Effort
    moving: tuple[Span, ...]
    resting: tuple[Span, ...]
    returns: tuple[ReturnHome, ...]
    truth: Track
    belief: Track
    states_off_map: int
    frames_off_map: int
    link: LinkSummary
    setting: MissionSetting

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
