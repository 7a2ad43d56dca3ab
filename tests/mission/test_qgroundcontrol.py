from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

from waypointctl.errors import MissionError
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.mission.qgroundcontrol import read_plan
from waypointctl.mission.survey import mission_text

HOME = [47.3977, 8.5456, 488.0]
STEP = 0.0001  # degrees: 11.12 m north, 7.55 m east


def item(command: int, *params: float | None, frame: int = 3) -> dict[str, Any]:
    values = [*params, *[None] * 7][:7]
    return {"type": "SimpleItem", "command": command, "frame": frame, "params": values, "autoContinue": True}


def plan(*items: dict[str, Any], **more: Any) -> dict[str, Any]:
    mission = {"version": 2, "plannedHomePosition": HOME, "items": list(items), "vehicleType": 10}
    return {"fileType": "Plan", "version": 1, "groundStation": "QGroundControl", "mission": mission, **more}


NORTH = item(16, 0, 0, 0, None, HOME[0] + STEP, HOME[1], 0)
EAST = item(16, 4, 1.5, 0, None, HOME[0], HOME[1] + STEP, 0)


def imported(tmp_path: Path, content: dict[str, Any]) -> Mission:
    path = tmp_path / "yard.plan"
    path.write_text(json.dumps(content))
    return parse_mission(mission_text(read_plan(path), "yard.plan", "p").encode(), "yard")


def test_waypoints_with_their_holds_and_radii(tmp_path: Path) -> None:
    mission = imported(tmp_path, plan(NORTH, EAST))
    north, east = mission.legs()
    assert mission.name == "yard"
    assert (north.x_m, north.y_m) == pytest.approx((0, 11.12), abs=0.01)
    assert (east.x_m, east.y_m) == pytest.approx((7.55, 0), abs=0.01)
    assert (north.acceptance, north.tolerance_m, north.hold_s) == ("box", 0.5, 0)
    assert (east.acceptance, east.tolerance_m, east.hold_s) == ("radius", 1.5, 4)


def test_a_takeoff_is_left_out_a_landing_and_a_return_are_places(tmp_path: Path) -> None:
    path = tmp_path / "yard.plan"
    path.write_text(json.dumps(plan(item(22, frame=2), EAST, item(20, frame=2))))
    survey = read_plan(path)
    assert survey.notes == ("mission.items[0]: a takeoff; the robot walks from where it stands",)
    assert [stop.name for stop in survey.stops] == ["", "home"]
    assert "# Left out: mission.items[0]: a takeoff" in mission_text(survey, "yard.plan", "p")
    landed = imported(tmp_path, plan(NORTH, item(21, 0, 0, 0, 0, HOME[0], HOME[1] + STEP, 0)))
    assert landed.legs()[1].name == "land"


def test_the_fence_comes_along(tmp_path: Path) -> None:
    square = [[HOME[0] - STEP, HOME[1] - STEP], [HOME[0] - STEP, HOME[1] + STEP], [HOME[0] + STEP, HOME[1]]]
    fence = {
        "version": 2,
        "circles": [{"circle": {"center": HOME[:2], "radius": 3.5}, "inclusion": False, "version": 1}],
        "polygons": [{"polygon": square, "inclusion": True, "version": 1}],
    }
    geofence = imported(tmp_path, plan(NORTH, geoFence=fence)).onboard.geofence
    assert [(area.center_m, area.radius_m) for area in geofence.keep_out] == [((0, 0), 3.5)]
    (area,) = geofence.keep_in
    assert area.corners is not None
    assert area.corners[0].position_m == pytest.approx((-7.55, -11.12), abs=0.01)


def test_long_legs_get_the_time_that_they_take(tmp_path: Path) -> None:
    far = item(16, 0, 0, 0, None, HOME[0] + 10 * STEP, HOME[1], 0)  # 111 m
    assert imported(tmp_path, plan(far)).defaults.timeout_s == 170
    assert imported(tmp_path, plan(NORTH)).defaults.timeout_s == 30


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    path = tmp_path / "yard.plan"
    rally = {"version": 2, "points": [[*HOME]]}
    path.write_text(json.dumps(plan(NORTH | {"autoContinue": False}, rallyPoints=rally)))
    assert read_plan(path).notes == (
        "mission.items[0]: that it waits here for a person (autoContinue)",
        "rallyPoints: 1; the robot has one home, onboard.home",
    )


def test_an_origin_leaves_the_home_where_the_robot_starts(tmp_path: Path) -> None:
    path = tmp_path / "yard.plan"
    path.write_text(json.dumps(plan(NORTH)))
    survey = read_plan(path, (HOME[0] - STEP, HOME[1]))
    mission = parse_mission(mission_text(survey, "yard.plan", "p").encode(), "yard")
    assert mission.start.position_m == pytest.approx((0, 11.12), abs=0.01)


def changed(*path: str | int, to: Any) -> dict[str, Any]:
    content = copy.deepcopy(plan(NORTH, EAST, geoFence={"version": 2, "circles": [], "polygons": []}))
    part: Any = content
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = to
    return content


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (changed("fileType", to="Parameters"), "fileType: 'Parameters' is not 'Plan'"),
        (changed("version", to=2), "version: 2 is not 1"),
        (changed("version", to=True), "version: true is not 1"),
        (changed("mission", to=[]), r"mission: a list of 0 is not a mapping"),
        (
            changed("mission", "plannedHomePosition", to=[95, 0]),
            r"plannedHomePosition\[0\]: 95 is not a number within -89",
        ),
        (
            changed("mission", "plannedHomePosition", to=[1]),
            "plannedHomePosition: has 1 numbers; latitude and longitude",
        ),
        (changed("mission", "items", to=[]), "has no waypoint to walk to"),
        (changed("mission", "items", 0, "type", to="ComplexItem"), r"items\[0\]\.type: 'ComplexItem' \(a survey"),
        (changed("mission", "items", 0, "type", to="Sample"), r"items\[0\]\.type: 'Sample' is not 'SimpleItem'"),
        (
            changed("mission", "items", 0, "command", to=178),
            r"command: 178 is nothing that a walking .* 16 \(waypoint\), 19",
        ),
        (changed("mission", "items", 0, "frame", to=1), r"items\[0\]\.frame: 1 is not 0 or 3"),
        (
            changed("mission", "items", 0, "params", to=[1, 2]),
            r"items\[0\]\.params: has 2 entries; a simple item has 7",
        ),
        (
            changed("mission", "items", 0, "params", to=[0, 0, 0, None, 0, None, 0]),
            "params: has no place: latitude and",
        ),
        (changed("mission", "items", 0, "params", 0, to=-1), r"params\[0\]: -1 is not a number within 0 and 86400"),
        (changed("mission", "items", 0, "command", to=20), r"items\[0\]: is a return \(command 20\), and more follows"),
        (changed("geoFence", "version", to=1), "geoFence.version: 1 is not 2"),
        (changed("geoFence", "polygons", to=[{"inclusion": True, "polygon": []}]), "has 0 corners; at least 3"),
        (
            changed("geoFence", "circles", to=[{"inclusion": 1, "circle": {}}]),
            r"circles\[0\]\.inclusion: 1 is not true or f",
        ),
        (
            changed("geoFence", "circles", to=[{"inclusion": True, "circle": {"center": HOME, "radius": 0}}]),
            r"circles\[0\]\.circle\.radius: 0 is not a number within 0\.001 and 20000",
        ),
    ],
)
def test_what_cannot_be_walked_is_refused_with_its_place(tmp_path: Path, content: dict[str, Any], problem: str) -> None:
    with pytest.raises(MissionError, match=problem):
        imported(tmp_path, content)


def test_all_that_is_wrong_is_said_at_once(tmp_path: Path) -> None:
    content = changed("mission", "items", 0, "command", to=178)
    content["mission"]["items"][1]["frame"] = 1
    with pytest.raises(
        MissionError, match=r"2 problems\n.*yard\.plan: mission\.items\[0\](.|\n)*yard\.plan: mission\.items\[1\]"
    ):
        imported(tmp_path, content)
