"""The Foxglove layout that travels in the log: import it in Foxglove or Lichtblick to see the flight.

Its form (configById, and a tree of splits) is what both programs export; they publish no schema of it.
"""

from __future__ import annotations

import json
from typing import Any, Final

from waypointctl.sim.geometry import WORLD

_COLORS: Final = ("#4e98e2", "#f5774d", "#5cd6a9", "#f7df71", "#a395e2")


def layout(root: str, *, camera: bool = False) -> bytes:
    """Return the layout as JSON, its view from behind the body `root`; with `camera` the robot's pictures too."""
    panels: dict[str, Any] = {
        "3D!scene": _scene_panel(root),
        "Plot!speed": _plot(
            "Speed [m/s]",
            {"true speed": "/odometry.linear_velocity.@norm", "speed the operator knows": "/telemetry.speed_mps"},
        ),
        "Plot!reward": _plot("Reward", {"total": "/reward.total", "terms": "/reward.terms[:].value"}),
        "Plot!latency": _plot(
            "Link delay [s]",
            {
                "commands, up": "/command.delay_s",
                "acknowledgements, down": "/ack.delay_s",
                "telemetry, down": "/telemetry.delay_s",
            },
        ),
        "StateTransitions!modes": {
            "paths": [
                {"value": path, "label": label, "timestampMethod": "receiveTime"}
                for label, path in {
                    "mode, as received": "/telemetry.mode",
                    "command, as received": "/ack.stage",
                    "motors": "/action.source",
                }.items()
            ],
            "isSynced": True,
        },
        "RosOut!log": {"topicToRender": "/log", "minLogLevel": 1, "searchTerms": []},
    }
    plots = _split("column", "Plot!speed", _split("column", "Plot!reward", "Plot!latency", 50), 34)
    history = _split("column", "StateTransitions!modes", "RosOut!log", 45)
    scene: Any = "3D!scene"
    if camera:
        panels["Image!camera"] = {"imageMode": {"imageTopic": "/camera"}}
        scene = _split("row", scene, "Image!camera", 60)
    whole = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split("row", _split("column", scene, history, 62), plots, 58),
    }
    return json.dumps(whole, indent=2).encode() + b"\n"


def _split(direction: str, first: Any, second: Any, percentage: int) -> dict[str, Any]:
    return {"direction": direction, "first": first, "second": second, "splitPercentage": percentage}


def _plot(title: str, paths: dict[str, str]) -> dict[str, Any]:
    lines = zip(paths.items(), _COLORS, strict=False)
    return {
        "title": title,
        "paths": [
            {"value": path, "label": label, "color": color, "enabled": True, "timestampMethod": "receiveTime"}
            for (label, path), color in lines
        ],
        "showLegend": True,
        "legendDisplay": "floating",
        "showPlotValuesInLegend": True,
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "isSynced": True,
        "xAxisVal": "timestamp",
    }


def _scene_panel(root: str) -> dict[str, Any]:
    return {
        "followMode": "follow-position",
        "followTf": root,
        "fixedFrame": WORLD,
        "cameraState": {
            "perspective": True,
            "distance": 14,
            "phi": 55,
            "thetaOffset": 45,
            "targetOffset": [0, 0, 0],
            "target": [0, 0, 0],
            "targetOrientation": [0, 0, 0, 1],
            "fovy": 45,
            "near": 0.1,
            "far": 5000,
        },
        "scene": {"transforms": {"showLabel": False, "axisScale": 0}},
        "transforms": {},
        "topics": {
            "/scene": {"visible": True},
            "/goal": {"visible": True},
            "/path": {"visible": True, "type": "line", "lineWidth": 0.05, "gradient": ["#5cd6a980", "#5cd6a9ff"]},
            "/waypoints": {"visible": False},
        },
        "layers": {
            "grid": {
                "layerId": "foxglove.Grid",
                "instanceId": "grid",
                "label": "Ground, 1 m",
                "visible": True,
                "frameId": WORLD,
                "frameLocked": True,
                "size": 40,
                "divisions": 40,
                "lineWidth": 1,
                "color": "#80808060",
                "position": [0, 0, 0.01],  # clear of the floor, or the two flicker
                "rotation": [0, 0, 0],
            }
        },
    }
