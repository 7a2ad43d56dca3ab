from __future__ import annotations

from pathlib import Path

import pytest

from tests.studies.standing import HERE
from waypointctl.errors import InputError, MissionError
from waypointctl.studies.case import AUTONOMIES, BUILT_IN, autonomies_of, load_route, load_routes


def test_the_papers_path_and_one_of_ten_waypoints_and_60_m_come_with_it() -> None:
    two, ten = (load_route(name).mission for name in ("two-point", "ten-point"))
    assert [(leg.x_m, leg.y_m, leg.tolerance_m, leg.acceptance) for leg in two.legs()] == [
        (7, 12, 0.5, "box"),
        (14, 14, 0.5, "box"),
    ]
    assert (len(ten.waypoints), round(ten.path_length_m())) == (10, 60)


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_route_has_the_name_that_it_is_asked_for_by(name: str) -> None:
    assert load_route(name).mission.name == name


def test_anybodys_mission_is_a_route(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_bytes(HERE)
    assert list(load_routes([str(tmp_path / "mine.yaml"), "short"])) == ["here", "short"]


def test_an_unknown_route_is_refused_with_those_there_are(tmp_path: Path) -> None:
    with pytest.raises(MissionError, match=r"there is no such file\n  Give .* two-point, ten-point, short"):
        load_route("three-point")
    with pytest.raises(MissionError, match="no such file"):
        load_route(str(tmp_path / "none.yaml"))


def test_two_routes_of_one_name_are_refused() -> None:
    with pytest.raises(InputError, match="'short' is the name of more than one"):
        load_routes(["short", "short"])


def test_autonomies_come_in_their_own_order() -> None:
    assert list(autonomies_of(["joint", "mission"])) == ["mission", "joint"]
    assert list(autonomies_of(list(AUTONOMIES))) == list(AUTONOMIES)
    with pytest.raises(
        InputError, match="--autonomy: 'steer' is not an autonomy; choose from mission, waypoint, short_range_goal"
    ):
        autonomies_of(["mission", "steer"])
