"""A dispatcher at an uplink that loses what it is told to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from waypointctl.flight.link.direction import NOISE, Delivery
from waypointctl.flight.operator.dispatcher import Dispatcher
from waypointctl.flight.operator.requests import CommandRequest
from waypointctl.flight.operator.timing import RetryPolicy
from waypointctl.log.messages import Ack, Command, CommandKind, CommandStage, Event, Mode, Stage, Telemetry

DELAY_NS = 1000
AIRTIME_NS = 10
ROUND_TRIP_NS = 2 * DELAY_NS
HOLD = CommandRequest(CommandKind.HOLD)


@dataclass
class Channel:
    """An uplink that loses what it is told to."""

    lose: list[bool] = field(default_factory=list)
    arrived: list[Command] = field(default_factory=list)

    def __call__(self, now_ns: int, make: Callable[[int], Command]) -> Delivery:
        left_ns = now_ns + AIRTIME_NS
        if self.lose and self.lose.pop(0):
            return Delivery(now_ns, left_ns, (), NOISE)
        self.arrived.append(make(left_ns + DELAY_NS))
        return Delivery(now_ns, left_ns, (left_ns + DELAY_NS,), "")


def ground(
    channel: Callable[[int, Callable[[int], Command]], Delivery], retries: int = 3, *, acknowledged: bool = True
) -> tuple[Dispatcher, list[CommandStage | Event]]:
    told: list[CommandStage | Event] = []
    retry_policy = RetryPolicy(acknowledged, retries, lambda left_ns: left_ns + ROUND_TRIP_NS, patience_ns=100)
    return Dispatcher(channel, retry_policy, told.append), told


def stages(told: list[CommandStage | Event]) -> list[tuple[int, Stage, int]]:
    return [(one.time_ns, one.stage, one.attempt) for one in told if isinstance(one, CommandStage)]


def ack(stage: Stage, command_id: int = 1) -> Ack:
    return Ack(command_id, stage, "", 0, 0)


def frame(mode: Mode) -> Telemetry:
    return Telemetry(0, mode, 0.0, 0.0, 0.0, 0.0, 0.0, -1, (), 1, 1)
