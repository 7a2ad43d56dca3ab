from __future__ import annotations

from pathlib import Path

import pytest

from tests.importers.reading import imported
from waypointctl.errors import MissionError

HOME = "0 1 0 16 0 0 0 0 60.0 25.0 10 1"
NORTH = "1 0 3 16 0 0 0 0 60.0002 25.0 10 1"
EAST = "2 0 3 16 5 2 0 0 60.0002 25.0004 10 1"
ON_THE_WAY = [(0.0, 22.28), (22.32, 22.28)]


def wpl(*lines: str) -> str:
    return "\n".join(("QGC WPL 110", *lines, ""))


@pytest.mark.parametrize(
    "content",
    [
        wpl(HOME, NORTH, EAST),
        wpl(HOME, NORTH, EAST).replace(" ", "\t").replace("QGC\tWPL\t", "QGC WPL "),
        wpl(HOME, NORTH, "", EAST).replace("\n", "\r\n"),
        "\ufeff" + wpl(HOME, NORTH, EAST),
        wpl("#MISSION", HOME, NORTH, "# the quarry", EAST),
        "\n \n" + wpl(HOME, NORTH, EAST),
        wpl(HOME, NORTH, EAST).replace("60.0002 25.0 ", "6.00002e1 +25.00000000 "),
        wpl(HOME, NORTH, EAST.replace("5 2 0 0", "5 2 0 nan")),
    ],
)
def test_items_are_walked_from_the_home(tmp_path: Path, content: str) -> None:
    found = imported(tmp_path, content, "yard.waypoints")
    assert (found.mission.name, found.mission.start.position_m) == ("yard", (0, 0))
    assert found.legs == ON_THE_WAY
    assert [(leg.hold_s, leg.tolerance_m) for leg in found.all_legs] == [(0, 0.5), (5, 2)]
    assert found.left_out == ()


def test_commands_mean_what_they_mean_in_a_plan(tmp_path: Path) -> None:
    content = wpl(
        HOME,
        "1 0 3 22 15 0 0 0 0 0 10 1",
        NORTH.replace("1 0 3", "2 0 3"),
        "3 0 0 178 1 5 0 0 0 0 0 1",
        "4 0 3 19 30 0 0 0 0 0 10 0",
        "5 0 0 177 2 1 0 0 0 0 0 1",
        "6 0 0 20 0 0 0 0 0 0 0 1",
    )
    found = imported(tmp_path, content, "copter.txt")
    assert found.legs == [(0.0, 22.28), (0.0, 22.28), (0.0, 0.0)]
    assert [leg.hold_s for leg in found.all_legs] == [30, 30, 0]
    assert found.left_out == (
        "1 x DO_CHANGE_SPEED (command 178): the policy sets the speed",
        "1 x takeoff (command 22): the robot stays on the ground",
        "2 x wait for a person (autoContinue is false): the robot continues",
    )


def test_a_mark_of_the_current_item_is_left_out(tmp_path: Path) -> None:
    found = imported(tmp_path, wpl(HOME, NORTH, EAST.replace("2 0 3", "2 1 3")), "yard.waypoints")
    assert found.left_out == ("1 x mark of line 4 as the current item: the mission starts with its first",)


def test_a_file_without_a_home_starts_at_the_origin(tmp_path: Path) -> None:
    without = wpl("0 1 3 22 0 0 0 0 60.0001 25 10 1", NORTH)
    assert imported(tmp_path, without, "yard.waypoints", origin=(60.0, 25.0)).legs == [(0.0, 11.14), (0.0, 22.28)]
    with pytest.raises(
        MissionError, match=r"the home \(item 0\) is missing\n  Give the place of the start: --origin 60"
    ):
        imported(tmp_path, without, "yard.waypoints")


def test_a_home_that_is_not_set_is_named_and_gives_way_to_an_origin(tmp_path: Path) -> None:
    unset = wpl(HOME.replace("60.0 25.0", "0 0"), NORTH, EAST)
    with pytest.raises(MissionError, match=r"line 2 \(the home\) \(0, 0\): some 7,000 km away from the other places"):
        imported(tmp_path, unset, "yard.waypoints")
    assert imported(tmp_path, unset, "yard.waypoints", origin=(60.0, 25.0)).legs == ON_THE_WAY


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        ("QGC WPL 120\n" + HOME, r"yard\.waypoints:1: begins with 'QGC WPL 120'; 'QGC WPL 110' is read"),
        (wpl(HOME), "has no waypoint to go to: at least one item of command 16 beside the home"),
        (wpl(), "has no waypoint to go to"),
        (wpl(HOME, NORTH[:-2]), "line 3: has 11 values; an item has 12"),
        (
            wpl(HOME, *[NORTH[:-2]] * 86),
            r"line 3: has 11 values; an item has 12 \(and 85 more of the kind, the last at",
        ),
        (wpl(HOME, NORTH.replace("60.0002", "60,0002")), "line 3: '60,0002' is not a number"),
        (wpl(HOME, NORTH.replace("60.0002", "inf")), "line 3: 'inf' is not a number"),
        (wpl(HOME, NORTH.replace("1 0 3 16", "1 0 3 16.5")), "line 3: its number, frame or command is not a whole"),
        (wpl(HOME, NORTH.replace("1 0 3 16", "1 0 3 92")), r"line 3\.command: 92 is NAV_GUIDED_ENABLE"),
        (wpl(HOME, NORTH.replace("1 0 3 16", "1 0 1 16")), r"line 3\.frame: 1 is not one with latitude"),
        (wpl(HOME, NORTH.replace("60.0002", "95")), r"line 3\.params: 95, 25 is not a latitude"),
        (wpl(HOME, *[NORTH] * 1001), "leads to more than the 1,000 waypoints"),
        (wpl(HOME, *[NORTH] * 20_000), "has 20,001 lines; at most 20,000 are read"),
        (wpl(HOME, NORTH).encode() + b"\xff", r"yard\.waypoints:4: is not UTF-8 text: byte 0xff"),
    ],
)
def test_what_cannot_be_walked_is_refused_with_its_line(tmp_path: Path, content: object, problem: str) -> None:
    with pytest.raises(MissionError, match=problem) as caught:
        imported(tmp_path, content, "yard.waypoints")
    assert str(caught.value).count("yard.waypoints") == 1
