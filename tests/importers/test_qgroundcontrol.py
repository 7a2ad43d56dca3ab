"""What a plan is refused for, and what of it makes no difference; what plans mean stands in plans.py."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest

from tests.importers.plans import YARD, A, B, box, circle, fence, item, landing, plan, there, wp
from tests.importers.reading import imported
from waypointctl.errors import MissionError
from waypointctl.importers.mavlink import FOLLOWED, other_commands

LEFT_OUT = {number: command for number, command in other_commands().items() if command.is_left_out}
REFUSED = {number: command for number, command in other_commands().items() if not command.is_left_out}


def test_commands_that_change_no_way_are_left_out_and_counted(tmp_path: Path) -> None:
    at_places = [there(command, 9, 9, 1, frame=3) for command in LEFT_OUT]
    found = imported(tmp_path, plan(A, *at_places, B, *[item(command, 1) for command in LEFT_OUT]))
    assert found.legs == [(0.0, 22.28), (22.32, 22.28)]
    assert found.left_out == tuple(
        f"2 x {command.name} (command {number}): {command.reason}" for number, command in LEFT_OUT.items()
    )


@pytest.mark.parametrize("command", [*REFUSED, 1, 99, 65_000, -16])
def test_a_command_that_changes_the_way_is_refused_with_its_name_and_place(tmp_path: Path, command: int) -> None:
    with pytest.raises(MissionError) as caught:
        imported(tmp_path, plan(A, there(command, 9, 9, 1), B))
    name = REFUSED[command].name if command in REFUSED else "not a mission command of MAVLink that is known"
    assert f"mission.items[1].command: {command} is {name}" in str(caught.value)


@pytest.mark.parametrize("command", [201, 216, 218, 400, 610, 2004, 2020, 2021, 2800, 40002, 42600, 60002, 60010])
def test_a_device_or_a_setting_changes_no_way(command: int) -> None:
    assert command in LEFT_OUT


def test_a_command_is_of_one_kind_alone() -> None:
    assert not FOLLOWED.keys() & other_commands().keys()


def changed(*path: str | int, to: Any) -> dict[str, Any]:
    content = copy.deepcopy(plan(A, B))
    part: Any = content
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = to
    return content


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (changed("fileType", to="Parameters"), "fileType: 'Parameters' is not 'Plan'"),
        (changed("fileType", to=None), "'fileType' is missing"),
        (changed("version", to=2), "version: 2 is not 1"),
        (changed("version", to=True), "version: true is not 1"),
        (changed("mission", to=[]), r"mission: a list of 0 is not a mapping"),
        (changed("mission", "version", to=7), r"mission\.version: 7 is not 2"),
        (changed("mission", "version", to="2"), r"mission\.version: '2' is not 2"),
        (
            changed("mission", "plannedHomePosition", to=[95, 0]),
            r"plannedHomePosition: 95, 0 is not a latitude within -90 and 90",
        ),
        (
            changed("mission", "plannedHomePosition", to=[1]),
            "plannedHomePosition: has 1 number; latitude and longitude",
        ),
        (
            changed("mission", "plannedHomePosition", to=[None, None, None]),
            r"mission\.plannedHomePosition is missing\n  Give the place of the start: --origin 60\.0002000,25\.0000",
        ),
        (changed("mission", "items", to=[]), "has no waypoint to go to"),
        (changed("mission", "items", to=[item(22, frame=3)]), "has no waypoint to go to"),
        (changed("mission", "items", to=[there(22, 0, 0)]), "has no waypoint besides the start"),
        (changed("mission", "items", to=[A] * 20_001), "items: has 20,001 entries; at most 20,000 are read"),
        (changed("mission", "items", to=[A] * 1001), "items: leads to more than the 1,000 waypoints"),
        (changed("mission", "items", 0, "type", to="ComplexItem"), r"items\[0\]: is a ComplexItem \(of no type\) with"),
        (
            changed("mission", "items", 0, to=landing("fwLandingPattern", landCoordinate=[60, 25, 0])),
            r"items\[0\]: 'loiterCoordinate' is missing",
        ),
        (changed("mission", "items", 0, "type", to="Sample"), r"items\[0\]\.type: 'Sample' is not 'SimpleItem'"),
        (changed("mission", "items", 0, "command", to="16"), r"command: '16' is not the number of a command"),
        (
            changed("mission", "items", 0, "command", to=17),
            r"items\[0\]: is a loiter without end .* and items follow it",
        ),
        (
            changed("mission", "items", 0, "command", to=20),
            r"items\[0\]: is a return \(command 20\), and items follow",
        ),
        (plan(A, item(93, 0, 12, 30)), r"items\[1\]: waits for a time of day, which a mission does not know"),
        (plan(A, item(93, -1, -1, -1, 20)), r"items\[1\]: waits for a time of day"),
        (changed("mission", "items", 0, "frame", to=1), r"items\[0\]\.frame: 1 is not one with latitude and longitude"),
        (changed("mission", "items", 0, "frame", to=None), r"items\[0\]\.frame: is missing; 0, 3, 5"),
        (
            changed("mission", "items", 0, "params", to=[1, 2]),
            r"items\[0\]\.params: has 2 entries; a simple item has 7",
        ),
        (changed("mission", "items", 0, "params", to={}), r"items\[0\]\.params: a mapping is not a list"),
        (changed("mission", "items", 0, "params", 4, to="60"), r"items\[0\]\.params\[4\]: '60' is not a number"),
        (changed("mission", "items", 0, "params", 4, to=1e999), r"params\[4\]: inf is not a number"),
        (
            changed("mission", "items", 0, "params", to=[0, 0, 0, None, 0, None, 0]),
            r"items\[0\]\.params: has no place: latitude and",
        ),
        (changed("mission", "items", 0, "params", 0, to=-1), r"params\[0\]: -1 s is not within 0 and 86400 s"),
        (changed("mission", "items", 0, "params", 1, to=300), r"params\[1\]: an acceptance radius of 300 m is not"),
        (plan(A, item(93, -1, 12, 30, 0), B), r"items\[1\]: waits for a time of day"),
        (plan(A, item(177, 9, 1), B), r"items\[1\]: is a jump \(command 177\) to 9, and no item has that number"),
        (plan(A, item(601, 5, 1), B), r"items\[1\]: is a jump to a tag \(command 601\) to 5, and no item"),
        (plan(A, B, item(177, 1, 600)), "items: leads to more than the 1,000 waypoints that a mission can have"),
        (plan(A, item(600, 1), item(178), item(601, 1, 1e9)), "items: leads to more than the 1,000 waypoints"),
        (
            plan(*[wp(2, at, frame=1) for at in range(86)]),
            r"items\[0\]\.frame: 1 is not .* \(and 85 more of the kind, ",
        ),
        (
            plan(*[item(16, 0, 0, 0, 0, 600_000_000 + at, 250_000_000, frame=3) for at in range(86)]),
            r"items\[0\]\.params: 600000000, 250000000 is not .*; they look like degrees times 10\^7 \(and 85 more",
        ),
        (
            plan(*[wp(2, at) for at in range(86)], home=[47.4, 8.5, 400]),
            r"mission\.plannedHomePosition \(47\.4, 8\.5\): some 1,800 km away from the other places",
        ),
        (plan(A, B, wp(2000, 0)), r"mission\.items\[2\] \(60\.2, 25\): some 22 km away from the other places"),
        (changed("geoFence", to=[1]), r"geoFence: a list of 1 is not a mapping"),
        (changed("geoFence", "polygons", to=[{"inclusion": True, "polygon": []}]), "has 0 corners; at least 3"),
        (changed("geoFence", "polygons", to=[box(0, 0, 1, 1, inclusion=True)] * 101), "polygons: has 101 entries"),
        (changed("geoFence", "polygons", to=[YARD | {"version": 2}]), r"polygons\[0\]\.version: 2 is not 1"),
        (changed("geoFence", "polygons", to=[YARD | {"inclusion": None}]), r"polygons\[0\]: 'inclusion' is missing"),
        (
            changed("geoFence", to={"polygon": YARD["polygon"]}),
            "geoFence: has a 'polygon', as version 1 had; version 2 has 'polygons'",
        ),
        (
            plan(A, B, fence=fence(box(-1000, -10, 1000, 10, inclusion=True))),
            r"geoFence\.polygons\[0\] spans 22\.3 km; the local frame is for at most 10 km",
        ),
        (
            plan(A, B, fence=fence(YARD, circle(9000, 0, 10, inclusion=False))),
            r"geoFence\.circles\[0\] \(60\.9, 25\): some 100 km away",
        ),
        (
            plan(A, B, fence=fence(YARD | {"polygon": [YARD["polygon"][at] for at in (0, 2, 1, 3)]})),
            r"geoFence\.polygons\[0\]: crosses itself: its side from corner 1 to corner 2 meets",
        ),
        (
            plan(A, B, fence=fence(box(-5, 3, 5, 3, inclusion=True))),
            r"geoFence\.polygons\[0\]: has all its corners on one line",
        ),
        (
            changed("geoFence", "circles", to=[{"inclusion": 1, "circle": {}}]),
            r"circles\[0\]\.inclusion: 1 is not true or f",
        ),
        (
            changed("geoFence", "circles", to=[{"inclusion": True, "circle": {"center": [60, 25], "radius": 0}}]),
            r"circles\[0\]\.circle\.radius: 0 is not a number within 0\.001 and 20000",
        ),
    ],
)
def test_what_cannot_be_walked_is_refused_with_its_place_one_problem_a_cause(
    tmp_path: Path, content: dict[str, Any], problem: str
) -> None:
    with pytest.raises(MissionError, match=problem) as caught:
        imported(tmp_path, content)
    assert str(caught.value).count("yard.plan") == 1


@pytest.mark.parametrize("content", [{}, {"version": 1}, {"circles": [], "version": 3}, [], {"breachReturn": None}])
def test_a_fence_that_holds_nothing_is_no_fence(tmp_path: Path, content: object) -> None:
    found = imported(tmp_path, plan(A, B, fence=content))
    assert (found.mission.onboard.geofence.keep_in, found.left_out) == ((), ())


def test_a_return_point_without_a_fence_is_left_out(tmp_path: Path) -> None:
    content = {"version": 2, "circles": [], "polygons": [], "breachReturn": [60.0003, 25.0001, 50]}
    found = imported(tmp_path, plan(A, B, fence=content))
    assert found.left_out == ("1 x geoFence.breachReturn: the fence holds nothing, and cannot be broken",)
    assert found.mission.onboard.home.position_m is None


def test_all_that_is_wrong_is_said_at_once(tmp_path: Path) -> None:
    content = changed("mission", "items", 0, "command", to=92)
    content["mission"]["items"][1]["command"] = 25
    with pytest.raises(
        MissionError, match=r"2 problems\n.*yard\.plan: mission\.items\[0\](.|\n)*yard\.plan: mission\.items\[1\]"
    ):
        imported(tmp_path, content)


def test_long_legs_and_a_long_way_home_get_the_time_that_they_take(tmp_path: Path) -> None:
    found = imported(
        tmp_path, plan(wp(10, 0), fence=fence(box(-50, -50, 50, 50, inclusion=True), breachReturn=[60, 25]))
    )
    assert (found.mission.defaults.timeout_s, found.mission.onboard.home.timeout_s) == (170, 300)  # 111 m
    found = imported(tmp_path, plan(A, fence=fence(YARD, breachReturn=[60.003, 25])))
    assert (found.mission.defaults.timeout_s, found.mission.onboard.home.timeout_s) == (40, 510)  # 334 m


def test_an_origin_leaves_the_home_where_the_robot_starts(tmp_path: Path) -> None:
    found = imported(tmp_path, plan(A, item(20)), origin=(59.9999, 25.0))
    assert found.mission.start.position_m == pytest.approx((0, 11.14), abs=0.01)
    assert found.legs == [(0.0, 33.42), (0.0, 11.14)]


def test_an_origin_far_from_everything_is_what_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match=r"--origin \(10, 10\): some [\d,]+ km away from the places of the file"):
        imported(tmp_path, plan(A, B), origin=(10.0, 10.0))


def test_a_list_for_a_plan_is_one_problem(tmp_path: Path) -> None:
    with pytest.raises(MissionError) as caught:
        imported(tmp_path, "[]", "e.plan")
    assert str(caught.value) == f"{tmp_path}/e.plan: a list of 0 is not a mapping of keys to values"
