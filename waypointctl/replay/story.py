"""The story of a flight, as frozen records: what was commanded, what was reached, how the robot fared.

All times are simulation time in [ns]. A `chronicle` gathers it from the flight's messages.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from waypointctl.log.messages import FINAL_STAGES, Ack, Event, EventKind, PlannedWaypoint, Stage
from waypointctl.log.setting import MissionSetting, Span
from waypointctl.replay.effort import Effort
from waypointctl.replay.link_story import LinkStory
from waypointctl.replay.return_home import ReturnHome
from waypointctl.replay.track import Track, is_on_map

UNFINISHED: Final = "unfinished"  # outcome of a log without an end


class Fate(StrEnum):
    """What became of a waypoint."""

    REACHED = "reached"
    TIMED_OUT = "timed out"
    SKIPPED = "skipped"
    OPEN = "not reached"


@dataclass(frozen=True, slots=True)
class CommandStory:
    """A command, from the operator's hand to what was heard of its end.

    Attributes:
        id: as it was sent.
        what: its kind and its waypoints, for people.
        issued_ns: on the operator's clock, the first time.
        received_ns: on the robot's clock, the first time; None before it has arrived.
        uplink_ns: how long the sending that arrived first was under way.
        onboard: the last stage it came to on board, None before it arrived.
        ended_ns: when it ended on board, on the robot's clock.
        attempts: how often it was sent.
        losses: how often the link lost it, which the operator is not told.
        acks: what has arrived of it at the operator, in order.
        told: its end as telemetry told it first, and when, on the operator's clock [ns]; None where it never did.
        arrivals: of each sending that arrived: when it was sent, and when it arrived [ns].
    """

    id: int
    what: str
    issued_ns: int
    received_ns: int | None
    uplink_ns: int | None
    onboard: Stage | None
    ended_ns: int | None
    attempts: int
    losses: int
    acks: tuple[Ack, ...]
    told: tuple[Stage, int] | None = None
    arrivals: tuple[tuple[int, int], ...] = ()

    @property
    def downlink_ns(self) -> int | None:
        """How old the first acknowledgement was when the operator received it."""
        return self.acks[0].received_ns - self.acks[0].issued_ns if self.acks else None

    @property
    def acknowledged_ns(self) -> int | None:
        """When the operator first heard of it again, on the operator's clock."""
        return self.acks[0].received_ns if self.acks else None

    @property
    def round_trip_ns(self) -> int | None:
        """From the sending that its first acknowledgement answers to that acknowledgement, on the operator's clock.

        That is the newest sending that had arrived when the robot acknowledged; the first one where none is known to.
        """
        if not self.acks:
            return None
        ack = self.acks[0]
        sent_ns = (sent_ns for sent_ns, arrived_ns in self.arrivals if arrived_ns <= ack.issued_ns)
        return ack.received_ns - max(sent_ns, default=self.issued_ns)

    @property
    def heard(self) -> Stage:
        """The last stage that the operator has heard of; SENT before the first acknowledgement."""
        heard = self.acks[-1].stage if self.acks else Stage.SENT
        return heard if heard in FINAL_STAGES or self.told is None else self.told[0]

    @property
    def concluded_ns(self) -> int | None:
        """When the operator heard that it had ended, on the operator's clock."""
        ended_ns = next((ack.received_ns for ack in self.acks if ack.stage in FINAL_STAGES), None)
        return self.told[1] if ended_ns is None and self.told is not None else ended_ns


@dataclass(frozen=True, slots=True)
class WaypointStory:
    """A waypoint, and what became of it.

    Attributes:
        planned: as it was, or would have been, commanded.
        fate: as the robot knows it.
        started_ns: when the robot set out for it, None if it never did.
        ended_ns: when it was reached or given up, None for a leg that was under way to the end.
        reached_ns: on the robot's clock.
        learned_ns: when the operator heard that it was reached.
    """

    planned: PlannedWaypoint
    fate: Fate
    started_ns: int | None
    ended_ns: int | None
    reached_ns: int | None
    learned_ns: int | None

    @property
    def is_on_map(self) -> bool:
        """Whether it can be drawn."""
        return is_on_map(self.planned.x_m, self.planned.y_m, self.planned.tolerance_m)


@dataclass(frozen=True, slots=True, eq=False)
class Story:
    """A flight, told.

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
        reward_total: the sum of what each step was paid.
        effort: distance and time.
        moving: when the robot moved by a policy's actions, on board or from the ground.
        resting: when it stood so still that physics slept.
        returns: each way home that began.
        truth: where the robot was.
        belief: where the operator was told it was.
        states_off_map: how many states `truth` and `effort` leave out, as no robot can be there.
        frames_off_map: how many telemetry frames `belief` leaves out.
        link: what it did besides delaying.
        setting: what the mission has fixed beforehand: home, zones, contact windows.
    """

    outcome: str
    reason: str
    ended_ns: int
    steps: int
    waypoints: tuple[WaypointStory, ...]
    places: tuple[PlannedWaypoint, ...]
    commands: tuple[CommandStory, ...]
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
    link: LinkStory
    setting: MissionSetting

    @property
    def reached(self) -> int:
        """How many waypoints the robot reached."""
        return sum(waypoint.fate is Fate.REACHED for waypoint in self.waypoints)

    @property
    def learned(self) -> int:
        """How many of them the operator has heard of."""
        return sum(waypoint.learned_ns is not None for waypoint in self.waypoints)

    @property
    def headline(self) -> str:
        """The outcome as the operator knows it; where the robot reached more waypoints than is known, both counts."""
        said = f"{self.outcome}: {self.reason}"
        if self.outcome == UNFINISHED or self.reached == self.learned:
            return said
        return f"{said}; the robot reached {self.reached}, the operator knows of {self.learned}"

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
