"""Build the ground station from a mission."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.link.direction import Direction
from waypointctl.flight.operator.dispatcher import Dispatcher, RetryPolicy, Uplink
from waypointctl.flight.operator.joint import JointOperator
from waypointctl.flight.operator.leg_clock import LegClock
from waypointctl.flight.operator.operator import Operator
from waypointctl.flight.operator.planner import MissionOperator, WaypointOperator
from waypointctl.flight.operator.requests import scheduled_requests
from waypointctl.flight.operator.station import HeartbeatSender, HeartbeatUplink, Station
from waypointctl.flight.operator.steering import ShortRangeGoalOperator
from waypointctl.flight.sink import Sink
from waypointctl.mission.mission import Mission
from waypointctl.units import ns

FloatArray = NDArray[np.float64]

_SCRIPTS: Final[dict[str, Callable[[Mission, Sink], Operator]]] = {
    "mission": MissionOperator,
    "waypoint": WaypointOperator,
}
_ACK_BYTES: Final = 64  # an acknowledgement with a reason of some words


def station_for(
    mission: Mission,
    joint: Callable[[], JointOperator],
    sink: Sink,
    uplink: Uplink,
    beats: HeartbeatUplink,
    answer_by: Callable[[int], int | None],
    patience_ns: int,
    leaves_ns: Callable[[int], int | None],
) -> Station:
    """Return the ground at mission start.

    Args:
        mission: the mission.
        joint: makes the operator that drives the robot from the ground, for autonomy `joint`.
        sink: takes the ground's own records.
        uplink: takes a command on its way.
        beats: takes a heartbeat on its way.
        answer_by: by when a command that leaves at a time [ns] has to be acknowledged; None for never.
        patience_ns: how much later than a frame an acknowledgement that was issued with it may come [ns].
        leaves_ns: when a command that is sent at a time [ns] leaves; None for never.
    """
    commands = mission.commands
    retry_policy = RetryPolicy(commands.acknowledged, commands.retries, answer_by, patience_ns)
    heartbeats = HeartbeatSender(beats, ns(mission.operator.heartbeat_s or 0.0))
    dispatcher = Dispatcher(uplink, retry_policy, sink)
    operator = _operator(mission, joint, sink, answer_by, leaves_ns)
    return Station(operator, scheduled_requests(mission), dispatcher, heartbeats)


def answer_time(up: Direction[Any], down: Direction[Any], robot_ns: int, margin_ns: int) -> Callable[[int], int | None]:
    """Return by when a command that leaves at a time [ns] has to be acknowledged: what the ground knows of its link.

    Round trip, jitter, what sending takes both ways and the next contact back are in it; queues on board are not.

    Args:
        up: the direction of commands.
        down: the direction of acknowledgements.
        robot_ns: how long the robot takes to answer at most [ns].
        margin_ns: how much later is still no loss [ns].
    """

    def at(left_ns: int) -> int | None:
        arrives_ns = left_ns + up.delay(left_ns) + _most_jitter_ns(up) + robot_ns
        placed = down.contacts.place(arrives_ns, _ACK_BYTES)
        if placed is None:
            return None
        _, back_ns = placed
        return back_ns + down.delay(back_ns) + _most_jitter_ns(down) + margin_ns

    return at


def patience_ns(down: Direction[Any], margin_ns: int) -> int:
    """Return how much later than a frame an acknowledgement that was issued with it may come [ns]."""
    return margin_ns + 2 * _most_jitter_ns(down)


def _most_jitter_ns(way: Direction[Any]) -> int:
    return 0 if way.jitter is None else max(way.jitter.most_ns, 0)


def leaving_time(up: Direction[Any]) -> Callable[[int], int | None]:
    """Return when a command that is sent at a time [ns] leaves: when a contact is open; queues are not known."""

    def at(sent_ns: int) -> int | None:
        placed = up.contacts.place(sent_ns, _ACK_BYTES)
        return None if placed is None else placed[1]

    return at


def _operator(
    mission: Mission,
    joint: Callable[[], JointOperator],
    sink: Sink,
    answer_by: Callable[[int], int | None],
    leaves_ns: Callable[[int], int | None],
) -> Operator:
    if mission.autonomy == "short_range_goal":
        return ShortRangeGoalOperator(mission, LegClock(answer_by, leaves_ns), sink)
    if mission.autonomy == "joint":
        return joint()
    return _SCRIPTS[mission.autonomy](mission, sink)
