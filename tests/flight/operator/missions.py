"""Missions for the tests of the ground."""

from __future__ import annotations

from waypointctl.log.messages import Ack, Mode, Stage, Telemetry
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Mission


def mission_of(text: str, waypoints: str = "[[4, 0], [4, 3]]") -> Mission:
    return parse_mission(f"name: t\npolicy: p\nwaypoints: {waypoints}\n{text}\n".encode(), "t.yaml")


def frame(
    x_m: float = 0.0, y_m: float = 0.0, reached: tuple[int, ...] = (), mode: Mode = Mode.NAVIGATING, issued_ns: int = 0
) -> Telemetry:
    return Telemetry(0, mode, x_m, y_m, 0.5, 0.0, 0.0, -1, reached, issued_ns, issued_ns)


def ack(stage: Stage, command_id: int = 1, reason: str = "", issued_ns: int = 0) -> Ack:
    return Ack(command_id, stage, reason, issued_ns, issued_ns)
