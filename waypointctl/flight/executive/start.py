"""How a command is processed on board.

A command that arrives for the first time is RECEIVED. Then, in this order, it is

1. REJECTED if its arguments are wrong (arguments.py) or a waypoint of it lies outside the fence,
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

from typing import Final

from waypointctl.flight.executive.commands import BEHAVIOURS, by, issued_before
from waypointctl.flight.executive.plan_execution import PlanExecution
from waypointctl.flight.executive.state_machine import UNDER_WAY, Signal
from waypointctl.log.messages import Command, CommandKind, Stage

SUPERSEDING: Final = frozenset({CommandKind.UPLOAD_PLAN, CommandKind.GO_TO, CommandKind.RETURN_HOME})


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
