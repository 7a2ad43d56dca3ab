from __future__ import annotations

from pathlib import Path

import pytest

from waypointctl.errors import MissionError
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import MOST_LEGS, Mission

PLACES = "waypoints: [[1, 0], {name: rock, position: [2 m, 0 m]}, [3, 0]]"


def mission_of(text: str, places: str = PLACES) -> Mission:
    return parse_mission(f"name: t\npolicy: p\n{places}\n{text}\n".encode(), "t.yaml")


def test_rounds_follow_one_another_and_each_leg_says_which_it_is() -> None:
    legs = mission_of("repeat: 2").legs()
    assert [leg.name for leg in legs] == ["WP1 (1)", "rock (1)", "WP3 (1)", "WP1 (2)", "rock (2)", "WP3 (2)"]
    assert [leg.index for leg in legs] == list(range(6))
    assert [leg.at for leg in legs] == [0, 1, 2, 0, 1, 2]
    assert [leg.x_m for leg in legs] == [1, 2, 3, 1, 2, 3]


def test_what_lies_before_the_waypoint_to_start_at_is_left_out_of_the_first_round_alone() -> None:
    assert [leg.name for leg in mission_of("start_at: rock").legs()] == ["rock", "WP3"]
    mission = mission_of("start_at: WP3\nrepeat: 2")
    assert [leg.name for leg in mission.legs()] == ["WP3 (1)", "WP1 (2)", "rock (2)", "WP3 (2)"]
    assert mission.num_legs == 4
    assert mission.path_length_m() == pytest.approx(3 + 2 + 1 + 1)


def test_a_mission_without_either_is_what_it_was() -> None:
    mission = mission_of("")
    assert [(leg.index, leg.at, leg.name) for leg in mission.legs()] == [(0, 0, "WP1"), (1, 1, "rock"), (2, 2, "WP3")]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("start_at: cliff", "'cliff' is not a waypoint; waypoints are WP1, rock, WP3"),
        ("repeat: 0", "expected a whole number from 1 to 1000; got 0"),
        ("repeat: 2\nstart_at: WP3\nexpect: {reached: 5}", "5 is more than the 4 waypoints"),
    ],
)
def test_what_cannot_be_walked_is_refused(text: str, said: str) -> None:
    with pytest.raises(MissionError, match=said):
        mission_of(text)


def test_more_legs_than_can_be_flown_are_refused() -> None:
    many = "waypoints: [" + ", ".join("[1, 0]" for _ in range(20)) + "]"
    with pytest.raises(MissionError, match=f"at most {MOST_LEGS:,}"):
        mission_of("repeat: 501", many)


def test_two_rounds_are_flown_with_each_waypoint_reached_twice() -> None:
    from waypointctl.flight.fly import fly
    from waypointctl.log.messages import Event, EventKind, Message
    from waypointctl.policy.bundle import load_policy

    policy = load_policy(Path(__file__).parents[2] / "policies" / "ant-waypoint")
    messages: list[Message] = []
    result = fly(mission_of("repeat: 2\nstart_at: rock"), policy, messages.append)
    assert (result.outcome, result.waypoints_reached, result.waypoints_total) == ("success", 5, 5)
    reached = [m.text for m in messages if isinstance(m, Event) and m.kind is EventKind.WAYPOINT_REACHED]
    assert reached == [f"{name} reached" for name in ("rock (1)", "WP3 (1)", "WP1 (2)", "rock (2)", "WP3 (2)")]
