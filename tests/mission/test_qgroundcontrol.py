from __future__ import annotations

import copy
import json
import re
from pathlib import Path
from typing import Any

import pytest

from waypointctl.errors import MissionError
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.mission.qgroundcontrol import read_plan
from waypointctl.mission.survey import Survey, mission_text

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


@pytest.mark.parametrize("picture", [item(2000, 0, 0, 1, frame=2), item(203, 0, 0, 0, 0, 1, frame=2)])
def test_one_picture_is_an_observation_of_the_waypoint_before_it(tmp_path: Path, picture: dict[str, Any]) -> None:
    path = tmp_path / "yard.plan"
    path.write_text(json.dumps(plan(picture, NORTH, picture, picture, EAST)))
    survey = read_plan(path)
    assert [stop.observe for stop in survey.stops] == [True, False]
    (note,) = survey.notes
    assert re.fullmatch(r"1 x \w[\w ]+ \(command \d+\) before the first waypoint", note)
    mission = parse_mission(mission_text(survey, "yard.plan", "p").encode(), "yard")
    assert [leg.observe for leg in mission.legs()] == [True, False]


@pytest.mark.parametrize(
    "pictures", [item(2000, 0, 2, 0, frame=2), item(2000, 0, 2, 9, frame=2), item(203, 1, frame=2)]
)
def test_pictures_at_intervals_are_left_out(tmp_path: Path, pictures: dict[str, Any]) -> None:
    path = tmp_path / "yard.plan"
    path.write_text(json.dumps(plan(NORTH, pictures, pictures)))
    survey = read_plan(path)
    assert [stop.observe for stop in survey.stops] == [False]
    assert survey.notes[0].startswith("2 x ")
    assert survey.notes[0].endswith(": only one picture at a time is taken, at a waypoint")


def test_a_takeoff_is_left_out_a_landing_and_a_return_are_places(tmp_path: Path) -> None:
    path = tmp_path / "yard.plan"
    path.write_text(json.dumps(plan(item(22, frame=2), EAST, item(20, frame=2))))
    survey = read_plan(path)
    assert survey.notes == ("1 x takeoff (command 22): the robot walks from where it stands",)
    assert [stop.name for stop in survey.stops] == ["", "home"]
    assert "# Left out: 1 x takeoff (command 22)" in mission_text(survey, "yard.plan", "p")
    landed = imported(tmp_path, plan(NORTH, item(21, 0, 0, 0, 0, HOME[0], HOME[1] + STEP, 0)))
    assert landed.legs()[1].name == "land"


def read(tmp_path: Path, *items: dict[str, Any]) -> Survey:
    path = tmp_path / "yard.plan"
    path.write_text(json.dumps(plan(*items)))
    return read_plan(path)


def test_what_changes_nothing_about_the_way_is_left_out_a_line_a_kind(tmp_path: Path) -> None:
    speed, camera, roi, yaw = item(178, 1, 5, frame=2), item(206, 25, 0, 1, frame=2), item(195, frame=2), item(115)
    survey = read(tmp_path, speed, NORTH, camera, roi, EAST, yaw, camera, speed, camera, item(20), item(2001))
    assert survey.stops == read(tmp_path, NORTH, EAST, item(20)).stops
    assert survey.notes == (
        "2 x DO_CHANGE_SPEED (command 178): the policy walks at its own speed",
        "3 x DO_SET_CAM_TRIGG_DIST (command 206): the camera takes one picture at a time, at a waypoint",
        "1 x DO_SET_ROI_LOCATION (command 195): there is no gimbal to point",
        "1 x CONDITION_YAW (command 115): where it faces is the policy's own",
        "1 x IMAGE_STOP_CAPTURE (command 2001): the camera takes one picture at a time, at a waypoint",
    )


@pytest.mark.parametrize("command", [17, 18, 31, 82, 21, 85])
def test_what_a_robot_on_the_ground_does_otherwise_is_walked_to_and_said(tmp_path: Path, command: int) -> None:
    there = item(command, 3, 0, 0, None, HOME[0] + STEP, HOME[1], 20)
    survey = read(tmp_path, EAST, there)
    assert [stop.place for stop in survey.stops[1:]] == [(HOME[0] + STEP, HOME[1])]
    assert (survey.stops[1].hold_s, survey.stops[1].radius_m) == (0, None)
    (note,) = survey.notes
    assert re.match(rf"1 x [a-zA-Z ]+ \(command {command}\): the (robot|mission) ", note)


@pytest.mark.parametrize("command", [17, 21, 85])
def test_what_ends_without_a_place_ends_where_the_robot_stands(tmp_path: Path, command: int) -> None:
    assert read(tmp_path, EAST, item(command, 0, 0, 0, None, 0, 0, 0, frame=2)).stops == read(tmp_path, EAST).stops


def test_a_delay_is_a_longer_hold_where_the_robot_is(tmp_path: Path) -> None:
    delay = item(93, 2.5, -1, -1, -1, frame=2)
    survey = read(tmp_path, delay, NORTH, EAST, delay, delay)
    assert [stop.hold_s for stop in survey.stops] == [0, 4 + 2 * 2.5]
    assert survey.notes == ("1 x delay (command 93) before the first waypoint: the robot sets out at once",)


def test_a_survey_is_walked_along_the_simple_items_that_it_was_laid_out_as(tmp_path: Path) -> None:
    inner = {"TransectStyleComplexItem": {"Items": [NORTH, item(206, 5, frame=2), EAST], "CameraShots": 3}}
    survey = read(tmp_path, {"type": "ComplexItem", "complexItemType": "survey", **inner}, NORTH)
    assert survey.stops == read(tmp_path, NORTH, EAST, NORTH).stops
    assert len(survey.notes) == 1


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
        "1 x wait for a person (autoContinue is false): the robot goes on",
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
            "plannedHomePosition: has 1 number; latitude and longitude",
        ),
        (changed("mission", "items", to=[]), "has no waypoint to walk to"),
        (changed("mission", "items", 0, "type", to="ComplexItem"), r"items\[0\]: is a ComplexItem \(no type\) without"),
        (changed("mission", "items", 0, "type", to="Sample"), r"items\[0\]\.type: 'Sample' is not 'SimpleItem'"),
        (
            changed("mission", "items", 0, "command", to=94),
            r"command: 94 is nothing that a walking .* 16 \(waypoint\), .*19 \(loiter\)",
        ),
        (changed("mission", "items", 0, "command", to=177), "command: 177 is DO_JUMP; the mission's 'repeat' walks"),
        (changed("mission", "items", 0, "command", to=17), r"items\[0\]: is a loiter without end .* more follows"),
        (changed("mission", "items", 0, "frame", to=1), r"items\[0\]\.frame: 1 is not 0 or 3"),
        (
            changed("mission", "items", 0, "params", to=[1, 2]),
            r"items\[0\]\.params: has 2 entries; a simple item has 7",
        ),
        (
            changed("mission", "items", 0, "params", to=[0, 0, 0, None, 0, None, 0]),
            r"items\[0\]\.params: has no place: latitude and",
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
    content = changed("mission", "items", 0, "command", to=94)
    content["mission"]["items"][1]["frame"] = 1
    with pytest.raises(
        MissionError, match=r"2 problems\n.*yard\.plan: mission\.items\[0\](.|\n)*yard\.plan: mission\.items\[1\]"
    ):
        imported(tmp_path, content)


def test_a_list_for_a_plan_is_one_problem(tmp_path: Path) -> None:
    path = tmp_path / "e.plan"
    path.write_text("[]")
    with pytest.raises(MissionError) as caught:
        read_plan(path)
    assert str(caught.value) == f"{path}: a list of 0 is not a mapping of keys to values"
