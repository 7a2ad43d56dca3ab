"""How a command is processed on board.

A command that arrives for the first time is RECEIVED. Then, in this order, it is

1. REJECTED if its arguments are wrong (`wrong_arguments`) or a waypoint of it lies outside the fence,
2. EXPIRED, "late", if its `expires` is over,
3. ACCEPTED and kept if its `not_before` is in the future,
4. SKIPPED, "overtaken by command 7", if one that was issued later has been executed and made it obsolete
   (command_ordering.py),
5. checked against the robot's mode and plan: REJECTED if it cannot be executed (`objection`), or SKIPPED, "late: ...",
   if it came too late to be of use (`lateness`): a release of what is released already, a skip of a waypoint that is
   over, a plan that arrives after its `not_before` and of which every waypoint has been reached,
6. ACCEPTED and STARTED. One that adds to the plan is STARTED when its first waypoint is next.

A command that was kept is checked as in 4 and 5 at its time, before commands that arrive then; those for the same time
are taken in the order of issue. One that cannot be executed then has FAILED. After its `expires` a command is
EXPIRED, not yet started or under way: its waypoints leave the plan, and the robot continues with the waypoints of other
commands, or stops. A command that arrives after its `not_before` and before its `expires` starts at once.

While an earlier command has not arrived, a command that refers to it cannot be distinguished from a wrong one. A
release, resume, tolerance or timeout without anything to change, and a cancel of an unknown command, are then
executed, and stored for the commands that are still to arrive.

docs/commands.md has this as a table for users.
"""

from __future__ import annotations

import math
from typing import Final

from waypointctl.flight.executive.commands import BEHAVIOURS, by, end_command, issued_before
from waypointctl.flight.executive.monitors import OBSERVE
from waypointctl.flight.executive.plan_execution import PlanExecution
from waypointctl.flight.executive.rules import FALL, GEOFENCE, Fence
from waypointctl.flight.executive.state_machine import UNDER_WAY, Signal
from waypointctl.log.messages import Command, CommandKind, Mode, PlannedWaypoint, Stage
from waypointctl.mission.fields import ACCEPTANCE_SHAPES, Coordinate, Hold, Timeout, Tolerance, bounds_of
from waypointctl.mission.mission import MOST_LEGS
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


is_coordinate, is_tolerance = bounds_of(Coordinate).fits, bounds_of(Tolerance).fits
is_timeout, is_hold = bounds_of(Timeout).fits, bounds_of(Hold).fits

SUPERSEDING: Final = frozenset({CommandKind.UPLOAD_PLAN, CommandKind.GO_TO, CommandKind.RETURN_HOME})


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
    if not is_timeout(seconds(waypoint.timeout_ns)):
        return f"{name}: a time-out of {seconds(waypoint.timeout_ns):g} s is out of bounds"
    if not is_hold(seconds(waypoint.hold_ns)):
        return f"{name}: a hold of {seconds(waypoint.hold_ns):g} s is out of bounds"
    if waypoint.task not in TASKS:
        return f"{name}: the task {waypoint.task!r:.40} is unknown"
    breach = fence.breach(waypoint.x_m, waypoint.y_m)
    return f"{GEOFENCE}: {name} at ({waypoint.x_m:g}, {waypoint.y_m:g}) {breach}" if breach else ""


def decide(execution: PlanExecution, now_ns: int, command: Command) -> None:
    """Start a command that has just arrived, keep it for its time, or end it."""
    tracker = execution.tracker
    cancelled, begun = execution.ordering.take_cancel(command) or (None, False)
    if execution.mode is Mode.FALLEN:
        tracker.advance(now_ns, command.id, Stage.REJECTED, FALL)
    elif reason := wrong_arguments(command, execution.rules.fence):
        tracker.advance(now_ns, command.id, Stage.REJECTED, reason)
    elif 0 <= command.expires_ns < now_ns:
        tracker.advance(now_ns, command.id, Stage.EXPIRED, "late")
    elif cancelled is None or (begun and BEHAVIOURS[command.kind].lasts):  # then it ends what came before it
        _start_or_keep(execution, now_ns, command)
    if cancelled is not None and tracker.is_open(command.id):
        end_command(execution, now_ns, command.id, Stage.CANCELLED, by(cancelled))


def _start_or_keep(execution: PlanExecution, now_ns: int, command: Command) -> None:
    if command.not_before_ns <= now_ns:
        start(execution, now_ns, command)
    elif not is_overtaken(execution, now_ns, command):
        execution.tracker.advance(now_ns, command.id, Stage.ACCEPTED)
        execution.tracker.postpone(command)


def start(execution: PlanExecution, now_ns: int, command: Command) -> None:
    """Check a command against newer commands and the robot's state, and execute it; it may have been kept."""
    kind, tracker = BEHAVIOURS[command.kind], execution.tracker
    kept = tracker.records[command.id].stage is Stage.ACCEPTED
    if is_overtaken(execution, now_ns, command):
        return
    if reason := kind.objection(execution, command):
        tracker.advance(now_ns, command.id, Stage.FAILED if kept else Stage.REJECTED, reason)
        return
    if reason := kind.lateness(execution, command):
        tracker.advance(now_ns, command.id, Stage.SKIPPED, reason)
        return
    if not kept:
        tracker.advance(now_ns, command.id, Stage.ACCEPTED)
    if command.kind in SUPERSEDING:
        execution.end_all(now_ns, Stage.SUPERSEDED, by(command.id))
    if not kind.waits:
        tracker.advance(now_ns, command.id, Stage.STARTED)
    kind.do(execution, now_ns, command)
    execution.ordering.record(command, command.not_before_ns if kept else now_ns)
    if not kind.lasts:
        tracker.advance(now_ns, command.id, Stage.COMPLETED)
    elif (hold_id := execution.ordering.held_by(command)) is not None and execution.mode in UNDER_WAY:
        execution.suspend(now_ns, Signal.PAUSE, by(hold_id))


def is_overtaken(execution: PlanExecution, now_ns: int, command: Command) -> bool:
    """Drop a command that a newer one made obsolete; an abort still ends what was issued before it."""
    later_id = execution.ordering.overtaking(command)
    if later_id is None or (command.kind is CommandKind.ABORT and issued_before(execution, command)):
        return False
    if command.kind is CommandKind.ABORT:
        execution.ordering.record(command, now_ns)  # older commands that are still to arrive are dropped too
    execution.tracker.advance(now_ns, command.id, Stage.SKIPPED, f"overtaken by command {later_id}")
    return True
