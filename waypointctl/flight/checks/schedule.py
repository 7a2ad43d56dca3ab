"""Findings on what is sent when, and on keys without effect."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.flight.checks import Finding
from waypointctl.flight.checks.link import loses_all
from waypointctl.flight.checks.traffic import Traffic
from waypointctl.flight.executive.rules import fence_of
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.mission import Mission
from waypointctl.mission.operator import ScheduledCommand
from waypointctl.units import ns, seconds

_ONE_AT_A_TIME: Final = "the robot gets one waypoint at a time, already released"
_NO_PLAN: Final = "the robot has no plan of its own"

# Which commands have no effect under an autonomy, and why.
_WITHOUT_EFFECT: Final[dict[tuple[str, str], str]] = {
    ("waypoint", "release"): _ONE_AT_A_TIME,
    ("short_range_goal", "release"): _ONE_AT_A_TIME,
    ("joint", "release"): _NO_PLAN,
    ("joint", "skip"): _NO_PLAN,
    ("joint", "set_tolerance"): _NO_PLAN,
    ("joint", "set_timeout"): _NO_PLAN,
    ("joint", "abort"): "the next action takes the motors again; hold stops it",
}
_LASTING: Final = ("go_to", "return_home")  # the others are completed as soon as they are executed
_ENDING: Final = ("go_to", "return_home", "abort", "cancel", "skip")  # these end the plan, or a part of it

_ON_BOARD: Final = ("mission", "waypoint", "short_range_goal")  # the robot computes its own actions

# Keys that only some autonomies use.
_USED_BY: Final[dict[tuple[str, str], tuple[str, ...]]] = {
    ("operator", "think_s"): ("waypoint", "short_range_goal"),
    ("operator", "released"): ("mission",),
    ("operator", "steering"): ("short_range_goal",),
    ("operator", "lookahead_m"): ("short_range_goal",),
    ("operator", "update_rate_hz"): ("short_range_goal",),
}
_RULES: Final = (("onboard", "stopped_tolerance_m"), ("onboard", "stuck"))


def schedule_findings(mission: Mission, traffic: Traffic) -> Iterator[Finding]:
    """Yield scheduled commands that the robot does not execute, and a plan that is never released to its end."""
    fence = fence_of(mission)
    for place, command in enumerate(mission.schedule):
        path = ("schedule", place)
        if command.position_m is not None and (breach := fence.breach(*command.position_m)):
            x_m, y_m = command.position_m
            yield Finding("fence", (*path, "position_m"), f"({x_m:g}, {y_m:g}) {breach}: the robot will reject it")
        elif found := _too_late(mission, traffic, command) or _without_effect(mission, command):
            field, text = found
            yield Finding("schedule", (*path, field), text)
    yield from _over_already(mission)
    yield from _last_hold(mission)
    yield from _release(mission)


def ends_plan(mission: Mission) -> bool:
    """Tell whether a scheduled command may end the plan, or a part of it, before all waypoints are reached."""
    return any(command.do in _ENDING for command in mission.schedule)


def _too_late(mission: Mission, traffic: Traffic, command: ScheduledCommand) -> tuple[str, str] | None:
    """Return the field and the text for a command that is sent, or arrives, too late to have an effect."""
    limit_s = mission.expect.max_time_s
    if limit_s is not None and command.at_s > limit_s:
        return "at_s", f"{command.do} is never sent: the flight ends at {limit_s:g} s, its expect.max_time"
    arrives_ns = traffic.arrival_ns(command, ns(command.at_s))
    if arrives_ns is None:
        return "at_s", f"{command.do} is never sent: no contact up has room for it from {command.at_s:g} s on"
    arrives_s = seconds(arrives_ns)
    if loses_all(mission.link.up.loss):
        return None  # reported for the link
    if command.expires_s is not None and command.expires_s < arrives_s:
        text = f"{command.do} expires at {command.expires_s:g} s and arrives at about {arrives_s:.2f} s"
        return "expires_s", f"{text}: it is not executed"
    executed_s = max(arrives_s, command.not_before_s or 0.0)
    if limit_s is not None and executed_s > limit_s:
        field, when = ("not_before_s", "is kept until") if executed_s > arrives_s else ("at_s", "arrives at about")
        return (
            field,
            f"{command.do} {when} {executed_s:.2f} s, and the flight ends at {limit_s:g} s, its expect.max_time",
        )
    return None


def _without_effect(mission: Mission, command: ScheduledCommand) -> tuple[str, str] | None:
    why = _WITHOUT_EFFECT.get((mission.autonomy, command.do))
    return None if why is None else ("do", f"{command.do} does nothing under autonomy {mission.autonomy}: {why}")


def _over_already(mission: Mission) -> Iterator[Finding]:
    """Yield what cancels a command that is completed as soon as it is executed, where all numbers are known."""
    if mission.autonomy != "mission":
        return
    in_turn = sorted(mission.schedule, key=lambda command: command.at_s)
    for place, command in enumerate(mission.schedule):
        if command.command is None or command.command < 2:  # the first is the plan
            continue
        meant = in_turn[command.command - 2]
        if meant.do not in _LASTING and (meant.not_before_s or 0.0) <= command.at_s:
            text = f"command {command.command} is the {meant.do} of {meant.at_s:g} s, which completes at once"
            yield Finding("schedule", ("schedule", place, "command"), text)


def _last_hold(mission: Mission) -> Iterator[Finding]:
    """Yield a hold that no later command ends."""
    last_s, place = max(((command.at_s, place) for place, command in enumerate(mission.schedule)), default=(0.0, -1))
    if place >= 0 and mission.schedule[place].do == "hold" and mission.expect.max_time_s is None:
        text = f"if the robot is under way at {last_s:g} s, the mission fails: no resume follows this hold"
        yield Finding("schedule", ("schedule", place, "do"), text)


def _release(mission: Mission) -> Iterator[Finding]:
    """Yield a plan of which a part is never released: the robot waits for it, and the operator for the end."""
    if mission.autonomy != "mission" or ends_plan(mission):
        return
    given = (mission.operator.released, *(command.released for command in mission.schedule))
    most = max(mission.num_legs if released < 0 else released for released in given if released is not None)
    if most < mission.num_legs:
        text = (
            f"{most} of {mission.num_legs} waypoints are released, and nothing in the schedule releases more: the "
            "robot waits for the rest, and the mission never ends"
        )
        yield Finding("release", ("operator", "released"), text, prevents=True)


def unused_findings(mission: Mission) -> Iterator[Finding]:
    """Yield what is written, is not the default, and does nothing."""
    for path, autonomies in _USED_BY.items():
        if mission.autonomy not in autonomies and _is_given(mission, path):
            yield _unused(path, mission, autonomies)
    yield from _steering(mission)
    yield from _sending(mission)
    if mission.autonomy == "joint":
        yield from _rules_on_board(mission)


def _steering(mission: Mission) -> Iterator[Finding]:
    path = ("operator", "update_rate_hz")
    if (
        mission.autonomy == "short_range_goal"
        and mission.operator.steering == "move_and_wait"
        and _is_given(mission, path)
    ):
        text = "does nothing while steering is move_and_wait; it is for 'steering: continuous'"
        yield Finding("unused", path, text)


def _sending(mission: Mission) -> Iterator[Finding]:
    """Yield heartbeats that no rule uses, and how to send again what is never sent again."""
    if mission.operator.heartbeat_s is not None and mission.onboard.link_loss is None:
        text = "does nothing without 'onboard.link_loss', the rule that uses heartbeats"
        yield Finding("unused", ("operator", "heartbeat_s"), text)
    for path in (("commands", "retries"), ("commands", "margin_s")):
        if not mission.commands.acknowledged and _is_given(mission, path):
            yield Finding("unused", path, "does nothing while acknowledged is false: nothing is sent again")


def _rules_on_board(mission: Mission) -> Iterator[Finding]:
    """Yield the rules for a robot that computes its own actions, where they are computed on the ground."""
    for path in _RULES:
        if _is_given(mission, path) and not _drives_by_itself(mission):
            yield _unused(path, mission, _ON_BOARD)
    place = ("on_failure",) if mission.on_failure is not None else ("onboard", "on_failure")
    rule = mission.failure_rule
    if rule.retry:
        yield _unused((*place, "retry"), mission, _ON_BOARD)
    if rule.then == "return_home":
        text = "does nothing under autonomy joint: the robot holds when a leg times out"
        yield Finding("unused", (*place, "then"), text)


def _drives_by_itself(mission: Mission) -> bool:
    """Tell whether the robot may compute its own actions for a while, under autonomy joint."""
    onboard = mission.onboard
    rules = (onboard.geofence.do, "" if onboard.link_loss is None else onboard.link_loss.do)
    return "return_home" in rules or any(command.do in ("go_to", "return_home") for command in mission.schedule)


def _unused(path: tuple[str, ...], mission: Mission, autonomies: tuple[str, ...]) -> Finding:
    allowed = autonomies[0] if len(autonomies) == 1 else f"{', '.join(autonomies[:-1])} or {autonomies[-1]}"
    return Finding("unused", path, f"does nothing under autonomy {mission.autonomy}; it is for autonomy {allowed}")


def _is_given(mission: Mission, path: tuple[str, str]) -> bool:
    """Tell whether a field is other than its default."""
    part: FileModel = getattr(mission, path[0])
    return bool(getattr(part, path[1]) != type(part).model_fields[path[1]].default)
