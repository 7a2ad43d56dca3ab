"""What a study learns of a flight, from its messages as they come."""

from __future__ import annotations

import math
from typing import Final, Literal

from pydantic import BaseModel, ConfigDict

from waypointctl.flight.outcome import FlightResult
from waypointctl.log.messages import FINAL_STAGES, Ack, Event, EventKind, Message, State
from waypointctl.studies.autonomy import AUTONOMIES
from waypointctl.studies.case import Case
from waypointctl.units import seconds

STILL_MPS: Final = 0.05  # a robot slower than this stands


class Flown(BaseModel):
    """A case and how it went."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    route: str
    autonomy: str
    rtt_s: float
    seed: int
    outcome: Literal["success", "failure"]  # as the operator knows it
    reason: str
    time_s: float  # on the operator's clock, from mission start until it knows how the mission ended
    distance_m: float  # that the robot has walked
    standing_s: float  # in which it was slower than STILL_MPS
    falls: int
    exchanges: int  # commands whose end the operator waited for before it went on

    @property
    def case(self) -> Case:
        """What was flown."""
        return Case(self.route, self.autonomy, self.rtt_s, self.seed)

    @property
    def succeeded(self) -> bool:
        """Whether the mission was a success."""
        return self.outcome == "success"


class Measure:
    """A sink that measures a flight. Distance and standing are the robot's truth, not what the operator is told."""

    def __init__(self) -> None:
        """Wait for the first message."""
        self._last: State | None = None
        self._last_speed_mps = 0.0
        self._distance_m = 0.0
        self._standing_ns = 0
        self._falls = 0
        self._concluded: set[int] = set()  # commands of whose end the operator has heard

    def __call__(self, message: Message) -> None:
        """Take a message."""
        if isinstance(message, State):
            self._move(message)
        elif isinstance(message, Ack):
            if message.stage in FINAL_STAGES:
                self._concluded.add(message.command_id)
        elif isinstance(message, Event) and message.kind is EventKind.FALL:
            self._falls += 1

    def flown(self, case: Case, result: FlightResult) -> Flown:
        """Return what has been measured of a flight that has ended as `result` says."""
        time_s = seconds(result.known_ns)
        return Flown(
            route=case.route,
            autonomy=case.autonomy,
            rtt_s=case.rtt_s,
            seed=case.seed,
            outcome="success" if result.outcome == "success" else "failure",
            reason=result.reason,
            time_s=time_s,
            distance_m=round(self._distance_m, 6),
            standing_s=min(seconds(self._standing_ns), time_s),  # the robot goes on to the end of its control period
            falls=self._falls,
            exchanges=len(self._concluded) if AUTONOMIES[case.autonomy].waits else 0,
        )

    def _move(self, state: State) -> None:
        if self._last is not None:
            # By time, not by number: a robot at rest has no states until something happens to it.
            if self._last_speed_mps < STILL_MPS:
                self._standing_ns += state.time_ns - self._last.time_ns
            self._distance_m += math.dist(state.qpos[:2].tolist(), self._last.qpos[:2].tolist())
        self._last = state
        self._last_speed_mps = math.hypot(*state.qvel[:2].tolist())
