"""What a mission sends over its link: the sizes of its messages, and when each would arrive."""

from __future__ import annotations

from typing import Any, Final

from waypointctl.flight.link.build import direction
from waypointctl.flight.link.contacts import BITS_PER_BYTE
from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.frames import size_bytes
from waypointctl.flight.operator.operator import planned_waypoints
from waypointctl.flight.operator.requests import CommandRequest, request_of
from waypointctl.log.messages import CommandKind, CommandStatus, Mode, Stage, Telemetry
from waypointctl.mission.mission import Mission
from waypointctl.mission.operator import ScheduledCommand

ACK_BYTES: Final = 64  # an acknowledgement with a reason of some words
_SOME_NS: Final = 100_000_000_000  # a time like those of a flight, for the sizes of messages


class Traffic:
    """Both ways of a mission's link with nothing else on them: without jitter, loss and queues.

    Attributes:
        up: of commands.
        down: of telemetry and acknowledgements.
        command_bytes: size of the largest command of the operator.
        frame_bytes: size of a frame of telemetry near the end of the mission.
        round_trip_ns: from a command at mission start to its acknowledgement; None where one of them never arrives.
    """

    def __init__(self, mission: Mission) -> None:
        """Take the link of a mission; raises MissionError where a file that it refers to is wrong."""
        link, files, seed = mission.link, mission.files, mission.seed
        self.up: Direction[Any] = direction(link.up, files, seed, "link.up")
        self.down: Direction[Any] = direction(link.down, files, seed, "link.down")
        self._mission = mission
        self.command_bytes = _command_bytes(mission)
        self.frame_bytes = _frame_bytes(mission)
        arrives_ns = _arrives_ns(self.up, 0, self.command_bytes)
        self.round_trip_ns = None if arrives_ns is None else _arrives_ns(self.down, arrives_ns, ACK_BYTES)

    @property
    def telemetry_bps(self) -> float:
        """Rate of the robot's telemetry while it moves [bit/s]."""
        return self.frame_bytes * BITS_PER_BYTE * self._mission.telemetry.rate_hz

    def arrival_ns(self, scheduled: ScheduledCommand, sent_ns: int) -> int | None:
        """Return when a scheduled command arrives [ns]; None for never."""
        return _arrives_ns(self.up, sent_ns, _order_bytes(request_of(scheduled, self._mission)))


def _arrives_ns(way: Direction[Any], now_ns: int, size: int) -> int | None:
    placed = way.contacts.place(now_ns, size)
    if placed is None:
        return None
    _, left_ns = placed
    return left_ns + way.delay(left_ns)


def _command_bytes(mission: Mission) -> int:
    plan = planned_waypoints(mission)
    if mission.autonomy == "mission":
        return _order_bytes(CommandRequest(CommandKind.UPLOAD_PLAN, plan))
    # Of those to single waypoints the one with the longest name is the largest, within some bytes.
    return _order_bytes(
        CommandRequest(CommandKind.GO_TO, (max(plan, key=lambda waypoint: len(waypoint.name.encode())),))
    )


def _frame_bytes(mission: Mission) -> int:
    count = mission.num_legs
    places = (1.5, 2.5, 0.55, 0.75, 2.0)
    under_way = (CommandStatus(1, Stage.STARTED),)
    return size_bytes(
        Telemetry(1000, Mode.NAVIGATING, *places, count, tuple(range(count)), _SOME_NS, _SOME_NS, under_way)
    )


def _order_bytes(order: CommandRequest) -> int:
    return size_bytes(order.command(1, 1, _SOME_NS, _SOME_NS))
