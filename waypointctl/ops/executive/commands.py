"""What each kind of command does on board.

A command that arrives for the first time is RECEIVED. Then, in this order, it is

1. REJECTED if its arguments are wrong (arguments.py) or a waypoint of it lies outside the fence,
2. EXPIRED, "late", if its `expires` is over,
3. ACCEPTED and kept if its `not_before` is still to come,
4. judged by what the robot is doing: REJECTED if it cannot be obeyed (`objection`), or SKIPPED, "late: ...", if it came
   too late to be of use (`lateness`): a release of what is released already, a skip of a waypoint that is over, a plan
   that arrives after its `not_before` and of which every waypoint has been reached,
5. ACCEPTED and STARTED. One that adds to the plan is STARTED when the robot comes to its first waypoint.

A command that was kept is judged as in 4 when its time has come; what cannot be obeyed then has FAILED. After its
`expires` a command is EXPIRED, not yet started or under way: its waypoints leave the plan, and the robot goes on with
what other commands want, or stands. What arrives after its `not_before` and before its `expires` starts at once.

docs/commands.md is the table of this for people.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from waypointctl.log.messages import Command, CommandKind, Mode, Stage
from waypointctl.ops.executive.machine import UNDER_WAY, Signal
from waypointctl.ops.executive.plan import Item
from waypointctl.ops.executive.walk import Walk
from waypointctl.units import ns


def _nothing(walk: Walk, command: Command) -> str:
    return ""


@dataclass(frozen=True, slots=True)
class Kind:
    """What a kind of command does.

    Attributes:
        do: does it, at a time [ns].
        objection: says why it cannot be obeyed now; empty if it can.
        lateness: says why it is of no use any more; empty if it is.
        lasts: whether it goes on until waypoints are over; the others are completed when they are done.
        waits: whether it is STARTED by the plan, when its turn comes.
    """

    do: Callable[[Walk, int, Command], None]
    objection: Callable[[Walk, Command], str] = _nothing
    lateness: Callable[[Walk, Command], str] = _nothing
    lasts: bool = False
    waits: bool = False


def by(command: Command) -> str:
    """Return the reason of what a command does to another."""
    return f"by command {command.id}"


def names_of(command: Command) -> str:
    """Return what a command is about, for people."""
    match command.kind:
        case CommandKind.CANCEL:
            return f"{command.target_id}"
        case CommandKind.SET_TOLERANCE:
            return f"{command.value:g} m"
        case CommandKind.SET_TIMEOUT:
            return f"{command.value:g} s"
        case CommandKind.RELEASE:
            return "all" if command.released < 0 else f"{command.released}"
    return ", ".join(waypoint.name for waypoint in command.waypoints)


def _replace_plan(walk: Walk, now_ns: int, command: Command) -> None:
    walk.plan.extend(command)
    walk.proceed(now_ns)


def _all_reached(walk: Walk, command: Command) -> str:
    late = 0 <= command.not_before_ns < command.received_ns
    if late and all(waypoint.index in walk.reached for waypoint in command.waypoints):
        return f"late: {names_of(command)} reached already"
    return ""


def _append(walk: Walk, now_ns: int, command: Command) -> None:
    walk.plan.extend(command)
    if walk.mode is Mode.DONE:
        walk.proceed(now_ns)
    else:
        walk.look_again()


def _no_plan(walk: Walk, command: Command) -> str:
    return "" if walk.plan.items else "there is no plan"


def _release(walk: Walk, now_ns: int, command: Command) -> None:
    walk.plan.release(command.released)
    item = walk.plan.current
    if walk.mode is Mode.WAITING and item is not None and item.released:
        walk.proceed(now_ns)
    else:
        walk.look_again()


def _more_than_planned(walk: Walk, command: Command) -> str:
    if command.released > len(walk.plan.items):
        return f"there are {len(walk.plan.items)} waypoints in the plan"
    return _no_plan(walk, command)


def _released_already(walk: Walk, command: Command) -> str:
    released, count = walk.plan.released, len(walk.plan.items)
    if released < (count if command.released < 0 else command.released):
        return ""
    return f"late: {released} of {count} waypoints are released already"


def _hold(walk: Walk, now_ns: int, command: Command) -> None:
    if walk.mode in UNDER_WAY or (walk.mode is Mode.SAFE and walk.can_go_on):
        walk.suspend(now_ns, Signal.PAUSE, by(command))
    elif walk.mode is Mode.STEERED:
        walk.rest()


def _resume(walk: Walk, now_ns: int, command: Command) -> None:
    walk.go_on(now_ns)


def _nothing_held(walk: Walk, command: Command) -> str:
    return "" if walk.can_go_on else "there is nothing to go on with"


def _skip(walk: Walk, now_ns: int, command: Command) -> None:
    item = _meant(walk, command)
    assert item is not None
    walk.pass_over(now_ns, item)


def _meant(walk: Walk, command: Command) -> Item | None:
    """Return the open waypoint that a skip is about: the one it names, or the current one."""
    if not command.waypoints:
        return walk.plan.current
    index = command.waypoints[0].index
    return next((item for item in walk.plan.open_items() if item.waypoint.index == index), None)


def _nothing_to_skip(walk: Walk, command: Command) -> str:
    if not command.waypoints:
        return "there is no waypoint to skip" if walk.plan.current is None else ""
    planned = any(item.waypoint.index == command.waypoints[0].index for item in walk.plan.items)
    return "" if planned else f"{names_of(command)} is not in the plan"


def _over_already(walk: Walk, command: Command) -> str:
    return "" if _meant(walk, command) else f"late: {names_of(command)} is over"


def _cancel(walk: Walk, now_ns: int, command: Command) -> None:
    take_back(walk, now_ns, command.target_id, Stage.CANCELLED, by(command))


def take_back(walk: Walk, now_ns: int, command_id: int, stage: Stage, reason: str) -> None:
    """End an open command, under way or not; the robot goes on with what other commands want, or stands."""
    if command_id in walk.under_way:
        walk.drop(now_ns, command_id, stage, reason)
    else:
        walk.life.advance(now_ns, command_id, stage, reason)


def _not_open(walk: Walk, command: Command) -> str:
    target_id, life = command.target_id, walk.life
    if target_id == command.id or not life.knows(target_id):
        return "unknown command"
    return "" if life.is_open(target_id) else f"already final: {life.records[target_id].stage}"


def _abort(walk: Walk, now_ns: int, command: Command) -> None:
    others = [command_id for command_id in walk.life.open_ids if command_id != command.id]
    walk.rest()
    for command_id in others:
        walk.life.advance(now_ns, command_id, Stage.CANCELLED, by(command))


def _set_tolerance(walk: Walk, now_ns: int, command: Command) -> None:
    walk.plan.change(walk.plan.open_items(), tolerance_m=command.value)
    walk.look_again()


def _set_timeout(walk: Walk, now_ns: int, command: Command) -> None:
    walk.plan.change(walk.plan.open_items(), timeout_ns=ns(command.value))
    walk.look_again()


def _none_to_come(walk: Walk, command: Command) -> str:
    return "there are no waypoints to come" if walk.plan.current is None else ""


def _return_home(walk: Walk, now_ns: int, command: Command) -> None:
    walk.go_home(now_ns, command.id)


KINDS: Final = {
    CommandKind.UPLOAD_PLAN: Kind(_replace_plan, lateness=_all_reached, lasts=True),
    CommandKind.APPEND_PLAN: Kind(_append, _no_plan, _all_reached, lasts=True, waits=True),
    CommandKind.RELEASE: Kind(_release, _more_than_planned, _released_already),
    CommandKind.GO_TO: Kind(_replace_plan, lateness=_all_reached, lasts=True),
    CommandKind.HOLD: Kind(_hold),
    CommandKind.RESUME: Kind(_resume, _nothing_held),
    CommandKind.SKIP: Kind(_skip, _nothing_to_skip, _over_already),
    CommandKind.CANCEL: Kind(_cancel, _not_open),
    CommandKind.ABORT: Kind(_abort),
    CommandKind.SET_TOLERANCE: Kind(_set_tolerance, _none_to_come),
    CommandKind.SET_TIMEOUT: Kind(_set_timeout, _none_to_come),
    CommandKind.RETURN_HOME: Kind(_return_home, lasts=True),
}
SUPERSEDING: Final = frozenset({CommandKind.UPLOAD_PLAN, CommandKind.GO_TO, CommandKind.RETURN_HOME})


def start(walk: Walk, now_ns: int, command: Command) -> None:
    """Judge a command by what the robot is doing, and do it; it is new, or has been kept until now."""
    kind, life = KINDS[command.kind], walk.life
    kept = life.records[command.id].stage is Stage.ACCEPTED
    if reason := kind.objection(walk, command):
        life.advance(now_ns, command.id, Stage.FAILED if kept else Stage.REJECTED, reason)
        return
    if reason := kind.lateness(walk, command):
        life.advance(now_ns, command.id, Stage.SKIPPED, reason)
        return
    if not kept:
        life.advance(now_ns, command.id, Stage.ACCEPTED)
    if command.kind in SUPERSEDING:
        walk.end_all(now_ns, Stage.SUPERSEDED, by(command))
    if not kind.waits:
        life.advance(now_ns, command.id, Stage.STARTED)
    kind.do(walk, now_ns, command)
    if not kind.lasts:
        life.advance(now_ns, command.id, Stage.COMPLETED)
