"""What a mission sends over its link: the sizes of its messages, and when each would arrive."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final

from waypointctl.flight.link.build import contacts_and_delay
from waypointctl.flight.link.contacts import BITS_PER_BYTE, Contacts
from waypointctl.flight.link.impairments import Delay
from waypointctl.mission.link import LinkDirection
from waypointctl.mission.mission import Mission
from waypointctl.mission.operator import ScheduledCommand

if TYPE_CHECKING:
    from waypointctl.flight.operator.requests import CommandRequest

_SOME_NS: Final = 100_000_000_000  # a time like those of a flight, for the sizes of messages


@dataclass(frozen=True, slots=True)
class EmptyDirection:
    """A direction of a link with nothing on it: without jitter, loss and queue."""

    contacts: Contacts
    delay: Delay
    queue_bytes: int

    def arrival_ns(self, sent_ns: int, size_bytes: Callable[[], int]) -> int | None:
        """Return when a message arrives [ns]; None for never.

        Args:
            sent_ns: it is handed to the link at that time.
            size_bytes: gives its size; called if a window has a rate.
        """
        placed = self.contacts.place(sent_ns, size_bytes() if self.contacts.has_rates else 0)
        if placed is None:
            return None
        _, left_ns = placed
        return left_ns + self.delay(left_ns)


class Traffic:
    """A mission's link with nothing on it, and the sizes of the mission's messages.

    A size is computed when a rate or a queue needs it: most missions have neither, and the modules that encode messages
    take longer to load than all checks.

    Attributes:
        up: of commands.
        down: of telemetry and acknowledgements.
        arrives_ns: when a command that is sent at mission start arrives; None for never.
        round_trip_ns: when its acknowledgement arrives; None where one of them never does.
    """

    def __init__(self, mission: Mission) -> None:
        """Take the link of a mission; raises MissionError where a file that it refers to is wrong."""
        self._mission = mission
        self.up = _direction(mission.link.up, mission.files)
        self.down = _direction(mission.link.down, mission.files)
        self.arrives_ns = self.up.arrival_ns(0, lambda: self.command_bytes)
        self.round_trip_ns = None if self.arrives_ns is None else self.down.arrival_ns(self.arrives_ns, _ack_bytes)

    @cached_property
    def command_bytes(self) -> int:
        """Size of the largest command of the operator."""
        from waypointctl.flight.operator.requests import CommandRequest, planned_waypoints
        from waypointctl.log.messages import CommandKind

        plan = planned_waypoints(self._mission)
        if self._mission.autonomy == "mission":
            return _request_bytes(CommandRequest(CommandKind.UPLOAD_PLAN, plan))
        # Of those to single waypoints the one with the longest name is the largest, within some bytes.
        longest = max(plan, key=lambda waypoint: len(waypoint.name.encode()))
        return _request_bytes(CommandRequest(CommandKind.GO_TO, (longest,)))

    @cached_property
    def frame_bytes(self) -> int:
        """Size of a frame of telemetry near the end of the mission."""
        from waypointctl.flight.link.frames import size_bytes
        from waypointctl.log.messages import CommandStatus, Mode, Stage, Telemetry

        count = self._mission.num_legs
        places = (1.5, 2.5, 0.55, 0.75, 2.0)
        under_way = (CommandStatus(1, Stage.STARTED),)
        return size_bytes(
            Telemetry(1000, Mode.NAVIGATING, *places, count, tuple(range(count)), _SOME_NS, _SOME_NS, under_way)
        )

    def sizes(self, way: str) -> dict[str, int]:
        """Return the sizes of the messages that travel "up" or "down", by what they are."""
        if way == "up":
            return {"the largest command": self.command_bytes}
        return {"an acknowledgement": _ack_bytes(), "a frame of telemetry": self.frame_bytes}

    @property
    def telemetry_bps(self) -> float:
        """Rate of the robot's telemetry while it moves [bit/s]."""
        return self.frame_bytes * BITS_PER_BYTE * self._mission.telemetry.rate_hz

    def arrival_ns(self, scheduled: ScheduledCommand, sent_ns: int) -> int | None:
        """Return when a scheduled command arrives [ns]; None for never."""
        return self.up.arrival_ns(sent_ns, lambda: self._scheduled_bytes(scheduled))

    def _scheduled_bytes(self, scheduled: ScheduledCommand) -> int:
        from waypointctl.flight.operator.requests import request_of

        return _request_bytes(request_of(scheduled, self._mission))


def _direction(way: LinkDirection, files: Mapping[str, bytes]) -> EmptyDirection:
    contacts, delay = contacts_and_delay(way, files)
    return EmptyDirection(contacts, delay, int(way.queue_bytes))


def _ack_bytes() -> int:
    from waypointctl.flight.operator.timing import ACK_BYTES

    return ACK_BYTES


def _request_bytes(request: CommandRequest) -> int:
    from waypointctl.flight.link.frames import size_bytes

    return size_bytes(request.command(1, 1, _SOME_NS, _SOME_NS))
