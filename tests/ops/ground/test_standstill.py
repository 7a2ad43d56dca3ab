"""A flight that ends because nobody tells the robot to go on says so."""

from __future__ import annotations

from typing import Any

import pytest

from tests.ops.flying import OUT_OF_REACH, UNDER_FOOT, flown, mission_of
from tests.ops.ground.missions import frame
from waypointctl.log.messages import Mode
from waypointctl.ops.ground.standstill import why_it_stands

FAR = OUT_OF_REACH | {"name": "far"}
YARD = {"keep_in": [{"center_m": [0.0, 0.0], "radius_m": 20.0}]}


@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "heading"])
def test_a_robot_that_holds_after_a_failed_leg_is_told_of(autonomy: str) -> None:
    result, _ = flown(mission_of(UNDER_FOOT, FAR, autonomy=autonomy, on_failure={"then": "hold"}, delay_ms=1000))
    assert result.outcome == "failure"
    said = "the robot holds after a failed leg at far, and nobody tells it to go on: 1 of 2 waypoints reached in "
    assert result.reason.startswith(said)


def test_so_is_one_that_waits_or_was_told_to_hold() -> None:
    result, _ = flown(mission_of(FAR, operator={"released": 0}))
    assert result.reason.startswith("the robot waits for the release of far, and nobody tells it to go on: 0 of 1")
    slow = FAR | {"timeout_s": 60.0}
    result, _ = flown(mission_of(slow, schedule=[{"at_s": 0.5, "do": "hold"}]))
    assert result.reason.startswith("the robot holds by command, and nobody tells it to go on: 0 of 1")


def test_a_mission_whose_time_is_over_first_says_it_too() -> None:
    late = {"max_time_s": 4.0}
    result, _ = flown(mission_of(FAR, on_failure={"then": "hold"}, expect=late))
    assert result.reason.startswith("longer than 4 s; the robot holds after a failed leg at far: 0 of 1 waypoints")
    result, _ = flown(mission_of(FAR | {"timeout_s": 60.0}, expect=late))
    assert result.reason.startswith("longer than 4 s: 0 of 1 waypoints")


@pytest.mark.parametrize(
    ("changes", "place", "said"),
    [
        ({"onboard": {"geofence": YARD}}, (25.0, 0.0), "the robot stands where it is outside keep-in"),
        (
            {"onboard": {"link_loss": {"after_s": 5.0, "do": "hold"}}},
            (3.0, 0.0),
            "the robot holds because it hears nothing from the ground",
        ),
        (
            {"on_failure": {"then": "return_home"}},
            (0.3, 0.2),
            "the robot is at home, where a rule on board has sent it",
        ),
        (
            {"on_failure": {"then": "return_home"}},
            (9.0, 0.0),
            "the robot stands by a rule on board (on_failure: return_home)",
        ),
        (
            {"onboard": {"geofence": {"keep_out": [{"name": "rock", "center_m": [5.0, 0.0], "radius_m": 1.0}]}}},
            (6.4, 0.0),
            "the robot holds by the fence, just beside a place that is inside keep-out rock",
        ),
        (
            {"onboard": {"geofence": YARD}, "on_failure": {"then": "hold"}},
            (19.5, 0.0),
            "the robot holds after a failed leg at far, or by the fence, just beside a place that is outside keep-in",
        ),
        (
            {"onboard": {"geofence": YARD}},
            (3.0, 0.0),
            "the robot stands by a rule on board (onboard.geofence.do: hold)",
        ),
    ],
)
def test_each_rule_has_its_words(changes: dict[str, Any], place: tuple[float, float], said: str) -> None:
    assert why_it_stands(mission_of(FAR, **changes), frame(*place, mode=Mode.SAFE)) == said


@pytest.mark.parametrize("mode", sorted(set(Mode) - {Mode.SAFE, Mode.PAUSED, Mode.WAITING}))
def test_one_that_has_nothing_to_go_on_with_needs_no_words(mode: Mode) -> None:
    assert why_it_stands(mission_of(FAR), frame(mode=mode)) == ""
    assert why_it_stands(mission_of(FAR), None) == ""
