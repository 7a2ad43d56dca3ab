"""What a mission sends over its link: the sizes of its messages, and when each would arrive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from waypointctl.flight.forecast.losses import loses_all
from waypointctl.flight.link.build import direction
from waypointctl.flight.link.contacts import BITS_PER_BYTE, Contacts
from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.frames import BodyFrame, ControlFrame
from waypointctl.flight.link.size import size_bytes
from waypointctl.flight.operator.operator import planned_waypoints
from waypointctl.flight.operator.order import Order
from waypointctl.flight.operator.schedule import order_of
from waypointctl.log.messages import Command, CommandKind, CommandStatus, Mode, PlannedWaypoint, Stage, Telemetry
from waypointctl.mission.mission import Mission
from waypointctl.mission.schedule import ScheduledCommand

ACK_BYTES: Final = 64  # an acknowledgement with a reason of some words

# The ant's, known without loading its model.
CONTROL_HZ: Final = 50.0
_QPOS: Final = 15
_QVEL: Final = 14
_MOTORS: Final = 8

_SOME_NS: Final = 100_000_000_000  # a time like those of a flight, for the sizes of messages


@dataclass(frozen=True, slots=True)
class Traffic:
    """Both ways of a link that nothing else is on.

    Attributes:
        up: of commands.
        down: of telemetry and acknowledgements.
        up_is_dead: whether everything is lost on the way up.
        down_is_dead: the same on the way down.
    """

    up: Direction[Any]
    down: Direction[Any]
    up_is_dead: bool = False
    down_is_dead: bool = False

    def arrives_up_ns(self, now_ns: int, size: int) -> int | None:
        """Return when a command that is sent now arrives [ns], without jitter and some losses; None for never."""
        return None if self.up_is_dead else _arrives_ns(self.up, now_ns, size)

    def heard_ns(self, now_ns: int) -> int | None:
        """Return when an acknowledgement sent now is heard [ns], without jitter and some losses; None for never."""
        return None if self.down_is_dead else _arrives_ns(self.down, now_ns, ACK_BYTES)


def traffic_of(mission: Mission) -> Traffic:
    """Return the link of a mission, with nothing in it."""
    link, files, seed = mission.link, mission.files, mission.seed
    up: Direction[Any] = direction(link.up, files, seed, "link.up")
    down: Direction[Any] = direction(link.down, files, seed, "link.down")
    return Traffic(up, down, loses_all(link.up.loss), loses_all(link.down.loss))


def command_bytes(mission: Mission) -> int:
    """Return the size of the largest command that the mission's operator sends [bytes]."""
    plan = planned_waypoints(mission)
    if mission.autonomy == "mission":
        return size_bytes(_command(CommandKind.UPLOAD_PLAN, plan))
    return max(go_to_bytes(waypoint) for waypoint in plan)


def go_to_bytes(waypoint: PlannedWaypoint) -> int:
    """Return the size of the command to walk to one waypoint [bytes]."""
    return size_bytes(_command(CommandKind.GO_TO, (waypoint,)))


def upload_bytes(mission: Mission) -> int:
    """Return the size of the whole plan as one command [bytes]."""
    return size_bytes(_command(CommandKind.UPLOAD_PLAN, planned_waypoints(mission)))


def scheduled_bytes(scheduled: ScheduledCommand, mission: Mission) -> int:
    """Return the size of a scheduled command [bytes]."""
    return size_bytes(order_of(scheduled, mission).command(1, 1, _SOME_NS, _SOME_NS))


def frame_bytes(mission: Mission) -> int:
    """Return the size of a frame of telemetry near the end of the mission [bytes]."""
    count = mission.num_legs
    places = (1.5, 2.5, 0.55, 0.75, 2.0)
    under_way = (CommandStatus(1, Stage.STARTED),)
    frame = Telemetry(1000, Mode.NAVIGATING, *places, count, tuple(range(count)), _SOME_NS, _SOME_NS, under_way)
    return size_bytes(frame)


def telemetry_bps(mission: Mission) -> float:
    """Return what the robot's telemetry comes to while it walks [bit/s]."""
    return frame_bytes(mission) * BITS_PER_BYTE * mission.telemetry.rate_hz


def body_bytes() -> int:
    """Return the size of the robot's state, as it comes down each control step under autonomy joint [bytes]."""
    return size_bytes(BodyFrame(0, np.zeros(_QPOS), np.zeros(_QVEL), 0, 0))


def action_bytes() -> int:
    """Return the size of an action, as it goes up each control step under autonomy joint [bytes]."""
    return size_bytes(ControlFrame(0, np.zeros(_MOTORS), 0, 0))


def mean_rate_bps(contacts: Contacts) -> float | None:
    """Return what a link can carry in the long run [bit/s], None for any amount.

    Contacts that come again count with their share of the time; of others the fastest counts, while it lasts.
    """
    rates = [window.rate_bps for window in contacts.windows]
    known = [rate for rate in rates if rate is not None]
    if not rates or len(known) < len(rates):
        return None
    if not contacts.period_ns:
        return max(known)
    sent = sum(rate * (window.end_ns - window.begin_ns) for rate, window in zip(known, contacts.windows, strict=True))
    return sent / contacts.period_ns


def _command(kind: CommandKind, waypoints: tuple[PlannedWaypoint, ...]) -> Command:
    return Order(kind, waypoints).command(1, 1, _SOME_NS, _SOME_NS)


def _arrives_ns(way: Direction[Any], now_ns: int, size: int) -> int | None:
    placed = way.contacts.place(now_ns, size)
    if placed is None:
        return None
    _, left_ns = placed
    return left_ns + way.delay(left_ns)
