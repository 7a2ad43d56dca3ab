"""The story of a flight, as frozen records: what was commanded, what was reached, how the robot fared.

All times are simulation time in [ns]. A `chronicle` gathers it from the flight's messages.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.log.messages import FINAL_STAGES, Ack, Event, EventKind, PlannedWaypoint, Stage
from waypointctl.replay.link_story import LinkStory
from waypointctl.units import NS_PER_S

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A hundred times as far as a mission can ask for. An altered log can say anything, even what no map has room for.
FARTHEST_M: Final = 1e6


def is_on_map(*values: float) -> bool:
    """Return whether places [m] and speeds [m/s] can be drawn and summed: finite, and at most FARTHEST_M."""
    return all(abs(value) <= FARTHEST_M for value in values)  # not so of a NaN


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
        """From issuing it to its first acknowledgement, both on the operator's clock."""
        return self.acks[0].received_ns - self.issued_ns if self.acks else None

    @property
    def heard(self) -> Stage:
        """The last stage that the operator has heard of; SENT before the first acknowledgement."""
        return self.acks[-1].stage if self.acks else Stage.SENT

    @property
    def concluded_ns(self) -> int | None:
        """When the operator heard that it had ended, on the operator's clock."""
        return next((ack.received_ns for ack in self.acks if ack.stage in FINAL_STAGES), None)


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
class Track:
    """Where the robot was: one row a control step of the truth, or a frame of telemetry, that is on the map."""

    time_ns: IntArray  # (n,) when it was there
    known_ns: IntArray  # (n,) when it was known: the same again for the truth, the arrival for telemetry
    x_m: FloatArray  # (n,)
    y_m: FloatArray  # (n,)
    speed_mps: FloatArray  # (n,) over ground

    def __len__(self) -> int:
        """Return n."""
        return len(self.time_ns)

    def thinned(self, most: int) -> Track:
        """Return every k-th row and the last one, so that there are no more than `most` + 1."""
        stride = max(1, -(-len(self) // most))
        rows = np.arange(0, len(self), stride)
        if len(rows) and rows[-1] != len(self) - 1:
            rows = np.append(rows, len(self) - 1)
        return Track(self.time_ns[rows], self.known_ns[rows], self.x_m[rows], self.y_m[rows], self.speed_mps[rows])


@dataclass(frozen=True, slots=True)
class Effort:
    """How the robot spent its time.

    Attributes:
        distance_m: the way of the torso over ground, standing sway included.
        walked_m: of that, while the policy had the motors.
        walking_ns: the policy had the motors.
        standing_ns: the standing controller had them.
        fallen_ns: they were off.
    """

    distance_m: float
    walked_m: float
    walking_ns: int
    standing_ns: int
    fallen_ns: int

    @property
    def mean_speed_mps(self) -> float | None:
        """The mean speed while walking, None if the robot never walked."""
        return self.walked_m * NS_PER_S / self.walking_ns if self.walking_ns else None

    @property
    def standing_share(self) -> float | None:
        """The share of the time that the robot stood, None if no time went by."""
        total = self.walking_ns + self.standing_ns + self.fallen_ns
        return self.standing_ns / total if total else None


@dataclass(frozen=True, slots=True, eq=False)
class Story:
    """A flight, told.

    Attributes:
        outcome: "success", "failure" or "interrupted"; "unfinished" for a log without an end.
        reason: why, in a few words.
        ended_ns: when the mission ended on the operator's clock, or the last time there is.
        steps: control steps flown.
        waypoints: of the mission, in order.
        commands: by id.
        events: in the order they happened.
        reward: each term's sum over the flight.
        reward_total: the sum of what each step was paid.
        effort: distance and time.
        truth: where the robot was.
        belief: where the operator was told it was.
        states_off_map: how many states `truth` and `effort` leave out, as no robot can be there.
        frames_off_map: how many telemetry frames `belief` leaves out.
        link: what it did besides delaying.
    """

    outcome: str
    reason: str
    ended_ns: int
    steps: int
    waypoints: tuple[WaypointStory, ...]
    commands: tuple[CommandStory, ...]
    events: tuple[Event, ...]
    reward: tuple[tuple[str, float], ...]
    reward_total: float
    effort: Effort
    truth: Track
    belief: Track
    states_off_map: int
    frames_off_map: int
    link: LinkStory

    @property
    def reached(self) -> int:
        """How many waypoints the robot reached."""
        return sum(waypoint.fate is Fate.REACHED for waypoint in self.waypoints)

    @property
    def learned(self) -> int:
        """How many of them the operator has heard of."""
        return sum(waypoint.learned_ns is not None for waypoint in self.waypoints)

    @property
    def falls(self) -> int:
        """How often the robot fell."""
        return sum(event.kind is EventKind.FALL for event in self.events)
