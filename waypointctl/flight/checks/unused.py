"""Findings on keys without effect: those that the autonomy, or another key, leaves unused."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.flight.checks.finding import Finding
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.mission import Mission

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
        if _is_given(mission, path) and not _walks_by_itself(mission):
            yield _unused(path, mission, _ON_BOARD)
    place = ("on_failure",) if mission.on_failure is not None else ("onboard", "on_failure")
    rule = mission.failure_rule
    if rule.retry:
        yield _unused((*place, "retry"), mission, _ON_BOARD)
    if rule.then == "return_home":
        text = "does nothing under autonomy joint: the robot holds when a leg times out"
        yield Finding("unused", (*place, "then"), text)


def _walks_by_itself(mission: Mission) -> bool:
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
