"""What each kind of command does on board; start.py decides when it is executed.

docs/commands.md has this as a table for users.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from waypointctl.flight.command_life import names
from waypointctl.flight.executive.plan import PlanItem
from waypointctl.flight.executive.plan_execution import PlanExecution
from waypointctl.flight.executive.state_machine import UNDER_WAY, Signal
from waypointctl.log.messages import TELEOPERATION, Command, CommandKind, Mode, Stage
from waypointctl.units import whole_ns


def _nothing(execution: PlanExecution, command: Command) -> str:
    return ""


@dataclass(frozen=True, slots=True)
class Behaviour:
    """What a kind of command does.

    Attributes:
        do: does it, at a time [ns].
        objection: returns why it cannot be executed now; empty if it can.
        lateness: returns why it is too late to be of use; empty if it is not.
        lasts: whether it runs until its waypoints are over; the others complete at once.
        waits: whether it is STARTED by the plan, when its turn comes.
    """

    do: Callable[[PlanExecution, int, Command], None]
    objection: Callable[[PlanExecution, Command], str] = _nothing
    lateness: Callable[[PlanExecution, Command], str] = _nothing
    lasts: bool = False
    waits: bool = False


def by(command_id: int) -> str:
    """Return the reason of what a command does to another."""
    return f"by command {command_id}"


def names_of(command: Command) -> str:
    """Return what a command refers to, for messages."""
    match command.kind:
        case CommandKind.CANCEL:
            return f"{command.target_id}"
        case CommandKind.SET_TOLERANCE:
            return f"{command.value:g} m"
        case CommandKind.SET_TIMEOUT:
            return f"{command.value:g} s"
        case CommandKind.RELEASE:
            return "all" if command.released < 0 else f"{command.released}"
    return names(command.waypoints)


def _replace_plan(execution: PlanExecution, now_ns: int, command: Command) -> None:
    _extend(execution, command)
    execution.proceed(now_ns)


def _extend(execution: PlanExecution, command: Command) -> None:
    """Add a command's waypoints to the plan, changed as those that were issued later and came before it want them."""
    plan, ordering = execution.plan, execution.ordering
    plan.extend(command)
    added = plan.open_items(command.id)
    timeout_s = ordering.value_for(command, CommandKind.SET_TIMEOUT)
    tolerance_m = ordering.value_for(command, CommandKind.SET_TOLERANCE)
    plan.change(added, tolerance_m=tolerance_m, timeout_ns=None if timeout_s is None else whole_ns(timeout_s))
    plan.release(ordering.released_for(command))


def _may_be_early(execution: PlanExecution, command: Command) -> bool:
    """Return whether what a command is about may still be on its way."""
    return not execution.tracker.knows_all_before(command.id)


def _all_reached(execution: PlanExecution, command: Command) -> str:
    late = 0 <= command.not_before_ns < command.received_ns
    if late and all(waypoint.index in execution.reached for waypoint in command.waypoints):
        return f"late: {names_of(command)} reached already"
    return ""


def _append(execution: PlanExecution, now_ns: int, command: Command) -> None:
    _extend(execution, command)
    if execution.mode is Mode.DONE:
        execution.proceed(now_ns)
    else:
        execution.retarget()


def _no_plan(execution: PlanExecution, command: Command) -> str:
    return "" if execution.plan.items else "there is no plan"


def _release(execution: PlanExecution, now_ns: int, command: Command) -> None:
    execution.plan.release(command.released)
    item = execution.plan.current
    if execution.mode is Mode.WAITING and item is not None and item.released:
        execution.proceed(now_ns)
    else:
        execution.retarget()


def _more_than_planned(execution: PlanExecution, command: Command) -> str:
    count = len(execution.plan.items)
    if 0 < count >= command.released or _may_be_early(execution, command):
        return ""
    if not count:
        return _no_plan(execution, command)
    return "there is 1 waypoint in the plan" if count == 1 else f"there are {count} waypoints in the plan"


def _released_already(execution: PlanExecution, command: Command) -> str:
    released, count = execution.plan.released, len(execution.plan.items)
    if released < (count if command.released < 0 else command.released) or _may_be_early(execution, command):
        return ""
    return f"late: {released} of {count} waypoints are released already"


def _hold(execution: PlanExecution, now_ns: int, command: Command) -> None:
    if execution.mode is Mode.TELEOPERATED:
        execution.stand_idle()
    elif command.target_id == TELEOPERATION:
        return  # a rule or a command has taken over: what it began goes on
    elif execution.mode in UNDER_WAY or (execution.mode is Mode.SAFE and execution.can_go_on):
        execution.suspend(now_ns, Signal.PAUSE, by(command.id))


def _resume(execution: PlanExecution, now_ns: int, command: Command) -> None:
    if execution.can_go_on:  # else the hold that it ends is still to arrive
        execution.resume(now_ns)


def _nothing_held(execution: PlanExecution, command: Command) -> str:
    return "" if execution.can_go_on or _may_be_early(execution, command) else "there is nothing to go on with"


def _skip(execution: PlanExecution, now_ns: int, command: Command) -> None:
    item = _meant(execution, command)
    assert item is not None
    execution.skip_item(now_ns, item, by(command.id))


def _meant(execution: PlanExecution, command: Command) -> PlanItem | None:
    """Return the open waypoint that a skip is about: the one it names, or the current one."""
    if not command.waypoints:
        return execution.plan.current
    index = command.waypoints[0].index
    return next((item for item in execution.plan.open_items() if item.waypoint.index == index), None)


def _nothing_to_skip(execution: PlanExecution, command: Command) -> str:
    if not command.waypoints:
        return "there is no waypoint to skip" if execution.plan.current is None else ""
    planned = any(item.waypoint.index == command.waypoints[0].index for item in execution.plan.items)
    return "" if planned else f"{names_of(command)} is not in the plan"


def _over_already(execution: PlanExecution, command: Command) -> str:
    return "" if _meant(execution, command) else f"late: {names_of(command)} is over"


def _cancel(execution: PlanExecution, now_ns: int, command: Command) -> None:
    if execution.tracker.knows(command.target_id):
        end_command(execution, now_ns, command.target_id, Stage.CANCELLED, by(command.id))
    else:
        execution.ordering.cancel(command.target_id, command.id, max(command.not_before_ns, command.received_ns))


def end_command(execution: PlanExecution, now_ns: int, command_id: int, stage: Stage, reason: str) -> None:
    """End an open command, under way or not; the robot continues with other commands, or stops."""
    if command_id in execution.under_way:
        execution.remove_command(now_ns, command_id, stage, reason)
    else:
        execution.tracker.advance(now_ns, command_id, stage, reason)


def _not_open(execution: PlanExecution, command: Command) -> str:
    target_id, tracker = command.target_id, execution.tracker
    if target_id == command.id or not (tracker.knows(target_id) or 1 <= target_id < command.id):
        return "unknown command"
    return (
        ""
        if tracker.is_open(target_id) or not tracker.knows(target_id)
        else f"already final: {tracker.records[target_id].stage}"
    )


def _abort(execution: PlanExecution, now_ns: int, command: Command) -> None:
    if execution.ordering.overtaking(command) is not None:
        for command_id in issued_before(execution, command):
            end_command(execution, now_ns, command_id, Stage.CANCELLED, by(command.id))
        return
    # What is under way may be newer: begun before the `not_before` of this one, or added to an older plan.
    under_way = execution.under_way
    ended = [
        command_id for command_id in execution.tracker.open_ids if command_id < command.id or command_id in under_way
    ]
    execution.stand_idle()
    for command_id in ended:
        execution.tracker.advance(now_ns, command_id, Stage.CANCELLED, by(command.id))


def issued_before(execution: PlanExecution, command: Command) -> list[int]:
    """Return the open commands that were issued before one."""
    return [command_id for command_id in execution.tracker.open_ids if command_id < command.id]


def _set_tolerance(execution: PlanExecution, now_ns: int, command: Command) -> None:
    execution.plan.change(execution.plan.open_items(), tolerance_m=command.value)
    execution.retarget()


def _set_timeout(execution: PlanExecution, now_ns: int, command: Command) -> None:
    execution.plan.change(execution.plan.open_items(), timeout_ns=whole_ns(command.value))
    execution.retarget()


def _none_to_come(execution: PlanExecution, command: Command) -> str:
    nothing = execution.plan.current is None and not _may_be_early(execution, command)
    return "there are no waypoints to come" if nothing else ""


def _return_home(execution: PlanExecution, now_ns: int, command: Command) -> None:
    execution.go_home(now_ns, command.id)


BEHAVIOURS: Final = {
    CommandKind.UPLOAD_PLAN: Behaviour(_replace_plan, lateness=_all_reached, lasts=True),
    CommandKind.APPEND_PLAN: Behaviour(_append, _no_plan, _all_reached, lasts=True, waits=True),
    CommandKind.RELEASE: Behaviour(_release, _more_than_planned, _released_already),
    CommandKind.GO_TO: Behaviour(_replace_plan, lateness=_all_reached, lasts=True),
    CommandKind.HOLD: Behaviour(_hold),
    CommandKind.RESUME: Behaviour(_resume, _nothing_held),
    CommandKind.SKIP: Behaviour(_skip, _nothing_to_skip, _over_already),
    CommandKind.CANCEL: Behaviour(_cancel, _not_open),
    CommandKind.ABORT: Behaviour(_abort),
    CommandKind.SET_TOLERANCE: Behaviour(_set_tolerance, _none_to_come),
    CommandKind.SET_TIMEOUT: Behaviour(_set_timeout, _none_to_come),
    CommandKind.RETURN_HOME: Behaviour(_return_home, lasts=True),
}
