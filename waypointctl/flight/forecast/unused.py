"""What a mission says that does nothing, for who decides what does not look at it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.flight.forecast.finding import Finding
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.mission import Mission

_ON_BOARD: Final = ("mission", "waypoint", "heading")  # the robot walks by itself to what it is told

# What only some autonomies look at.
_LOOKED_AT_BY: Final[dict[tuple[str, str], tuple[str, ...]]] = {
    ("operator", "think_s"): ("waypoint", "heading"),
    ("operator", "released"): ("mission",),
    ("operator", "steering"): ("heading",),
    ("operator", "lookahead_m"): ("heading",),
    ("operator", "update_rate_hz"): ("heading",),
}
_OF_A_WALK: Final = (("onboard", "slip_m"), ("onboard", "stuck"))


def unused_findings(mission: Mission) -> Iterator[Finding]:
    """Yield what is written, is not the default, and does nothing."""
    for path, autonomies in _LOOKED_AT_BY.items():
        if mission.autonomy not in autonomies and _is_given(mission, path):
            yield _unused(path, mission, autonomies)
    yield from _steering(mission)
    yield from _sending(mission)
    if mission.autonomy == "joint":
        yield from _rules_of_a_walk(mission)


def _steering(mission: Mission) -> Iterator[Finding]:
    path = ("operator", "update_rate_hz")
    if mission.autonomy == "heading" and mission.operator.steering == "move_and_wait" and _is_given(mission, path):
        text = "does nothing while steering is move_and_wait; it is for 'steering: continuous'"
        yield Finding("unused", path, text)


def _sending(mission: Mission) -> Iterator[Finding]:
    """Yield heartbeats that nobody listens for, and how to send again what is never sent again."""
    if mission.operator.heartbeat_s is not None and mission.onboard.link_loss is None:
        text = "does nothing without 'onboard.link_loss', the rule that listens for heartbeats"
        yield Finding("unused", ("operator", "heartbeat_s"), text)
    for path in (("commands", "retries"), ("commands", "margin_s")):
        if not mission.commands.acknowledged and _is_given(mission, path):
            yield Finding("unused", path, "does nothing while acknowledged is false: nothing is sent again")


def _rules_of_a_walk(mission: Mission) -> Iterator[Finding]:
    """Yield the rules for a robot that walks by itself, where the ground moves it."""
    for path in _OF_A_WALK:
        if _is_given(mission, path) and not _walks_by_itself(mission):
            yield _unused(path, mission, _ON_BOARD)
    place = ("on_failure",) if mission.on_failure is not None else ("onboard", "on_failure")
    rule = mission.failure_rule
    if rule.retry:
        yield _unused((*place, "retry"), mission, _ON_BOARD)
    if rule.then == "return_home":
        text = "does nothing under autonomy joint: when a leg's time is out, the pilot tells the robot to hold"
        yield Finding("unused", (*place, "then"), text)


def _walks_by_itself(mission: Mission) -> bool:
    """Tell whether a robot that a pilot moves may have a way to walk alone."""
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
