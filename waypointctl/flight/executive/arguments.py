"""Checks of a command's arguments, independent of the robot's state: within a mission's bounds."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, get_args

from waypointctl.flight.executive.fence import Fence
from waypointctl.flight.executive.leg_update import OBSERVE
from waypointctl.flight.executive.rules import GEOFENCE
from waypointctl.log.messages import Command, CommandKind, PlannedWaypoint
from waypointctl.mission.fields import ACCEPTANCE_SHAPES, Coordinate, Hold, Timeout, Tolerance
from waypointctl.mission.mission import MOST_LEGS
from waypointctl.mission.quantity import Quantity
from waypointctl.units import seconds

FAILURE_WORDS: Final = ("", "abort", "skip", "hold", "return_home")
TASKS: Final = ("", OBSERVE)

# How many waypoints each kind takes, at least and at most; the others take none.
_WAYPOINTS: Final = {
    CommandKind.UPLOAD_PLAN: (1, MOST_LEGS),
    CommandKind.APPEND_PLAN: (1, MOST_LEGS),
    CommandKind.GO_TO: (1, 1),
    CommandKind.SKIP: (0, 1),
}


def _bounds(field: object) -> Callable[[float], bool]:
    """Return the test that a mission file's field puts its number to."""
    (quantity,) = (part for part in get_args(field) if isinstance(part, Quantity))
    least = -math.inf if quantity.ge is None else quantity.ge
    above = -math.inf if quantity.gt is None else quantity.gt
    most = math.inf if quantity.le is None else quantity.le
    return lambda value: least <= value <= most and value > above


is_coordinate = _bounds(Coordinate)
is_tolerance = _bounds(Tolerance)
is_timeout = _bounds(Timeout)
is_hold = _bounds(Hold)


def wrong_arguments(command: Command, fence: Fence) -> str:
    """Return what is wrong with a command whatever the robot is doing; empty if nothing is."""
    if command.id < 1:
        return "an id counts from 1"
    least, most = _WAYPOINTS.get(command.kind, (0, 0))
    count = len(command.waypoints)
    if not least <= count <= most:
        wanted = f"{least}" if least == most else f"{least} to {most:,}"
        return f"{command.kind} takes {wanted} waypoint{'s' * (most != 1)}, and has {count:,}"
    if 0 <= command.expires_ns < command.not_before_ns:
        return "it expires before it may start"
    if not math.isfinite(command.value):
        return f"its value is {command.value:g}"
    if command.on_failure not in FAILURE_WORDS:
        return f"on_failure is {command.on_failure!r:.40}"
    return _wrong_value(command) or next(filter(None, (_wrong_place(w, fence) for w in command.waypoints)), "")


def _wrong_value(command: Command) -> str:
    match command.kind:
        case CommandKind.SET_TOLERANCE if not is_tolerance(command.value):
            return f"a tolerance of {command.value:g} m is out of bounds"
        case CommandKind.SET_TIMEOUT if not is_timeout(command.value):
            return f"a time-out of {command.value:g} s is out of bounds"
        case CommandKind.UPLOAD_PLAN | CommandKind.APPEND_PLAN if not -1 <= command.released <= len(command.waypoints):
            return f"it releases {command.released} of {len(command.waypoints)} waypoints"
        case CommandKind.RELEASE if command.released < -1:
            return f"it releases {command.released} waypoints"
    return ""


def _wrong_place(waypoint: PlannedWaypoint, fence: Fence) -> str:
    name = waypoint.name
    if not (is_coordinate(waypoint.x_m) and is_coordinate(waypoint.y_m)):
        return f"{name} at ({waypoint.x_m:g}, {waypoint.y_m:g}) is out of bounds"
    if waypoint.acceptance not in ACCEPTANCE_SHAPES or not is_tolerance(waypoint.tolerance_m):
        return f"{name}: acceptance {waypoint.acceptance!r:.40} within {waypoint.tolerance_m:g} m is out of bounds"
    if waypoint.timeout_ns < 1 or not is_timeout(seconds(waypoint.timeout_ns)):
        return f"{name}: a time-out of {seconds(waypoint.timeout_ns):g} s is out of bounds"
    if not is_hold(seconds(waypoint.hold_ns)):
        return f"{name}: a hold of {seconds(waypoint.hold_ns):g} s is out of bounds"
    if waypoint.task not in TASKS:
        return f"{name}: the task {waypoint.task!r:.40} is unknown"
    breach = fence.breach(waypoint.x_m, waypoint.y_m)
    return f"{GEOFENCE}: {name} at ({waypoint.x_m:g}, {waypoint.y_m:g}) {breach}" if breach else ""
