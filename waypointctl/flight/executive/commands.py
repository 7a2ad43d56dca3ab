"""What each kind of command does on board; start.py says when it comes to that.

docs/commands.md is the table of this for people.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from waypointctl.flight.executive.machine import UNDER_WAY, Signal
from waypointctl.flight.executive.plan import Item, names
from waypointctl.flight.executive.walk import Walk
from waypointctl.log.messages import Command, CommandKind, Mode, Stage
from waypointctl.units import whole_ns


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


def by(command_id: int) -> str:
    """Return the reason of what a command does to another."""
    return f"by command {command_id}"


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
    return names(command.waypoints)


def _replace_plan(walk: Walk, now_ns: int, command: Command) -> None:
    _extend(walk, command)
    walk.proceed(now_ns)


def _extend(walk: Walk, command: Command) -> None:
    """Add a command's waypoints to the plan, changed as those that were issued later and came before it want them."""
    plan, sequence = walk.plan, walk.sequence
    plan.extend(command)
    added = plan.open_items(command.id)
    timeout_s = sequence.value_for(command, CommandKind.SET_TIMEOUT)
    tolerance_m = sequence.value_for(command, CommandKind.SET_TOLERANCE)
    plan.change(added, tolerance_m=tolerance_m, timeout_ns=None if timeout_s is None else whole_ns(timeout_s))
    plan.release(sequence.released_for(command))


def _may_be_early(walk: Walk, command: Command) -> bool:
    """Tell whether what a command is about may still be on its way."""
    return not walk.life.knows_all_before(command.id)


def _all_reached(walk: Walk, command: Command) -> str:
    late = 0 <= command.not_before_ns < command.received_ns
    if late and all(waypoint.index in walk.reached for waypoint in command.waypoints):
        return f"late: {names_of(command)} reached already"
    return ""


def _append(walk: Walk, now_ns: int, command: Command) -> None:
    _extend(walk, command)
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
    count = len(walk.plan.items)
    if 0 < count >= command.released or _may_be_early(walk, command):
        return ""
    if not count:
        return _no_plan(walk, command)
    return "there is 1 waypoint in the plan" if count == 1 else f"there are {count} waypoints in the plan"


def _released_already(walk: Walk, command: Command) -> str:
    released, count = walk.plan.released, len(walk.plan.items)
    if released < (count if command.released < 0 else command.released) or _may_be_early(walk, command):
        return ""
    return f"late: {released} of {count} waypoints are released already"


def _hold(walk: Walk, now_ns: int, command: Command) -> None:
    if walk.mode in UNDER_WAY or (walk.mode is Mode.SAFE and walk.can_go_on):
        walk.suspend(now_ns, Signal.PAUSE, by(command.id))
    elif walk.mode is Mode.TELEOPERATED:
        walk.rest()


def _resume(walk: Walk, now_ns: int, command: Command) -> None:
    if walk.can_go_on:  # else what it resumes after is still to come
        walk.go_on(now_ns)


def _nothing_held(walk: Walk, command: Command) -> str:
    return "" if walk.can_go_on or _may_be_early(walk, command) else "there is nothing to go on with"


def _skip(walk: Walk, now_ns: int, command: Command) -> None:
    item = _meant(walk, command)
    assert item is not None
    walk.pass_over(now_ns, item, by(command.id))


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
    if walk.life.knows(command.target_id):
        take_back(walk, now_ns, command.target_id, Stage.CANCELLED, by(command.id))
    else:
        walk.sequence.cancel(command.target_id, command.id, max(command.not_before_ns, command.received_ns))


def take_back(walk: Walk, now_ns: int, command_id: int, stage: Stage, reason: str) -> None:
    """End an open command, under way or not; the robot goes on with what other commands want, or stands."""
    if command_id in walk.under_way:
        walk.drop(now_ns, command_id, stage, reason)
    else:
        walk.life.advance(now_ns, command_id, stage, reason)


def _not_open(walk: Walk, command: Command) -> str:
    target_id, life = command.target_id, walk.life
    if target_id == command.id or not (life.knows(target_id) or 1 <= target_id < command.id):
        return "unknown command"
    return (
        ""
        if life.is_open(target_id) or not life.knows(target_id)
        else f"already final: {life.records[target_id].stage}"
    )


def _abort(walk: Walk, now_ns: int, command: Command) -> None:
    if walk.sequence.overtaking(command) is not None:
        for command_id in issued_before(walk, command):
            take_back(walk, now_ns, command_id, Stage.CANCELLED, by(command.id))
        return
    # What is under way may be newer: begun before the `not_before` of this one, or added to an older plan.
    under_way = walk.under_way
    ended = [command_id for command_id in walk.life.open_ids if command_id < command.id or command_id in under_way]
    walk.rest()
    for command_id in ended:
        walk.life.advance(now_ns, command_id, Stage.CANCELLED, by(command.id))


def issued_before(walk: Walk, command: Command) -> list[int]:
    """Return the open commands that were issued before one."""
    return [command_id for command_id in walk.life.open_ids if command_id < command.id]


def _set_tolerance(walk: Walk, now_ns: int, command: Command) -> None:
    walk.plan.change(walk.plan.open_items(), tolerance_m=command.value)
    walk.look_again()


def _set_timeout(walk: Walk, now_ns: int, command: Command) -> None:
    walk.plan.change(walk.plan.open_items(), timeout_ns=whole_ns(command.value))
    walk.look_again()


def _none_to_come(walk: Walk, command: Command) -> str:
    nothing = walk.plan.current is None and not _may_be_early(walk, command)
    return "there are no waypoints to come" if nothing else ""


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
