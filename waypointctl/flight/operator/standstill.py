"""Why a robot stands, and where, as the ground knows it from its newest frame of telemetry."""

from __future__ import annotations

import math
from typing import Final

from waypointctl.flight.executive.machine import ON_FOOT
from waypointctl.flight.executive.rules import AT_HOME, GEOFENCE, LEG_FAILED, LINK_LOST, rules_of
from waypointctl.log.messages import Mode, Telemetry
from waypointctl.mission.mission import Mission

_NEARLY: Final = 1.5  # times home's tolerance: the robot stands a little way on from where it stopped


def why_it_stands(mission: Mission, frame: Telemetry | None) -> str:
    """Return what a robot waits for that stands with something left to do; empty for one that does not."""
    if frame is None:
        return ""
    if frame.mode is Mode.PAUSED:
        return "the robot holds by command"
    if frame.mode is Mode.WAITING:
        return f"the robot waits for the release of {_next_name(mission, frame)}"
    return _why_safe(mission, frame) if frame.mode is Mode.SAFE else ""


def _why_safe(mission: Mission, frame: Telemetry) -> str:
    """Return which rule on board made the robot stand."""
    if frame.cause.startswith(AT_HOME):
        return f"the robot is at home, where a rule on board has sent it ({frame.cause.removeprefix(AT_HOME)})"
    if frame.cause.startswith(LEG_FAILED):
        return f"the robot holds after a failed leg at {_next_name(mission, frame)}"
    if frame.cause.startswith(GEOFENCE):
        return f"the robot holds by its {frame.cause}"
    if frame.cause == LINK_LOST:
        return "the robot holds because it hears nothing from the ground"
    return "the robot stands by a rule on board"


def where_it_is(mission: Mission, frame: Telemetry | None, *, went_home: bool) -> str:
    """Return where the robot is, as far as the ground knows; empty where it has heard nothing.

    Args:
        mission: what was asked.
        frame: the newest that has arrived.
        went_home: whether the ground has heard of a way home.
    """
    if frame is None:
        return ""
    place = f"at ({frame.x_m:.2f}, {frame.y_m:.2f}) m"
    if frame.mode is Mode.FALLEN:
        return f"the robot has fallen {place}"
    if frame.mode in ON_FOOT:
        return f"the robot walks{' home' * (frame.mode is Mode.RETURNING)}, {place}"
    home = rules_of(mission).home
    away_m = math.dist((frame.x_m, frame.y_m), (home.x_m, home.y_m))
    is_home = frame.cause.startswith(AT_HOME) or (went_home and away_m <= _NEARLY * home.tolerance_m)
    return f"the robot is at home, {place}" if is_home else f"the robot stands {place}"


def _next_name(mission: Mission, frame: Telemetry) -> str:
    """Return the waypoint that the robot is about; where it does not say so, the first that it has not reached."""
    names = {leg.index: leg.name for leg in mission.legs()}
    if frame.target in names:
        return names[frame.target]
    return next((name for index, name in names.items() if index not in frame.reached), "its waypoint")
