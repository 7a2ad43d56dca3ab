"""A flight that ends because no command follows says so."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from tests.flight.flying import OUT_OF_REACH, UNDER_FOOT, flown, mission_of, only
from tests.flight.operator.missions import frame
from waypointctl.flight.outcome import last_known_place, standing_reason
from waypointctl.log.messages import Mode, Telemetry

FAR = OUT_OF_REACH | {"name": "far"}


@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "short_range_goal"])
def test_a_robot_that_holds_after_a_failed_leg_is_told_of(autonomy: str) -> None:
    result, _ = flown(mission_of(UNDER_FOOT, FAR, autonomy=autonomy, on_failure={"then": "hold"}, delay_ms=1000))
    assert result.outcome == "failure"
    said = "the robot holds after a failed leg at far, and no command followed: 1 of 2 waypoints reached in "
    assert result.reason.startswith(said)


def test_so_is_one_that_waits_or_was_told_to_hold() -> None:
    result, _ = flown(mission_of(FAR, operator={"released": 0}))
    assert result.reason.startswith("the robot waits for the release of far, and no command followed: 0 of 1")
    slow = FAR | {"timeout_s": 60.0}
    result, _ = flown(mission_of(slow, schedule=[{"at_s": 0.5, "do": "hold"}]))
    assert result.reason.startswith("the robot holds by command, and no command followed: 0 of 1")


def test_a_mission_whose_time_is_over_first_says_it_too() -> None:
    late = {"max_time_s": 4.0}
    result, _ = flown(mission_of(FAR, on_failure={"then": "hold"}, expect=late))
    assert result.reason.startswith(
        "the mission took longer than 4 s; the robot holds after a failed leg at far: 0 of 1 waypoints"
    )
    result, _ = flown(mission_of(FAR | {"timeout_s": 60.0}, expect=late))
    assert result.reason.startswith("the mission took longer than 4 s: 0 of 1 waypoints")


@pytest.mark.parametrize(
    ("cause", "said"),
    [
        ("geofence: the robot is outside keep-in", "the robot holds by its geofence: the robot is outside keep-in"),
        ("link lost", "the robot holds because the link is lost"),
        ("leg failed: far timeout", "the robot holds after a failed leg at far"),
        ("at home: stuck", "a rule on board sent the robot home (stuck)"),
        ("", "the robot holds because of a rule on board"),
    ],
)
def test_each_rule_has_its_words(cause: str, said: str) -> None:
    assert standing_reason(mission_of(FAR), replace(frame(mode=Mode.SAFE), cause=cause)) == said


@pytest.mark.parametrize(
    ("changes", "cause", "ends"),
    [
        ({"on_failure": "hold"}, "leg failed: far timeout", "after a failed leg at far, and no command followed"),
        ({"on_failure": "return_home"}, "at home: timeout", "the robot is at home, at"),
        (
            {"onboard": {"link_loss": {"after_s": 0.5, "do": "hold"}}},
            "link lost",
            "the robot holds because the link is lost, and no command followed",
        ),
        (
            {"onboard": {"link_loss": {"after_s": 0.5, "do": "return_home"}}},
            "at home: link lost",
            "the robot is at home",
        ),
    ],
)
def test_telemetry_tells_which_rule_acted_although_several_might_have(
    changes: dict[str, Any], cause: str, ends: str
) -> None:
    yard = {"geofence": {"keep_in": [{"center_m": [0.0, 0.0], "radius_m": 600.0}]}}
    onboard = yard | changes.get("onboard", {})
    result, messages = flown(mission_of(FAR, **(changes | {"onboard": onboard}), delay_ms=200))
    assert only(Telemetry, messages)[-1].cause == cause
    assert ends in result.reason
    assert result.outcome == "failure"


@pytest.mark.parametrize("mode", sorted(set(Mode) - {Mode.SAFE, Mode.PAUSED, Mode.WAITING}))
def test_one_that_has_nothing_to_go_on_with_needs_no_words(mode: Mode) -> None:
    assert standing_reason(mission_of(FAR), frame(mode=mode)) == ""
    assert standing_reason(mission_of(FAR), None) == ""


@pytest.mark.parametrize(
    ("mode", "place", "cause", "went_home", "said"),
    [
        (Mode.FALLEN, (1.0, 2.0), "", True, "the robot has fallen at (1.00, 2.00) m"),
        (Mode.NAVIGATING, (1.0, 2.0), "", False, "last telemetry: navigating, at (1.00, 2.00) m"),
        (Mode.RETURNING, (1.0, 2.0), "timeout", True, "last telemetry: returning, at (1.00, 2.00) m"),
        (Mode.SAFE, (0.6, 0.1), "at home: stuck", True, "the robot is at home, at (0.60, 0.10) m"),
        (Mode.IDLE, (0.6, 0.1), "", True, "the robot is at home, at (0.60, 0.10) m"),
        (Mode.IDLE, (0.6, 0.1), "", False, "the robot is at (0.60, 0.10) m"),
        (Mode.PAUSED, (9.0, 0.1), "by command 3", True, "the robot is at (9.00, 0.10) m"),
    ],
)
def test_the_ground_says_where_the_robot_is(
    mode: Mode, place: tuple[float, float], cause: str, went_home: bool, said: str
) -> None:
    told = replace(frame(*place, mode=mode), cause=cause)
    assert last_known_place(mission_of(FAR), told, went_home=went_home) == said
    assert last_known_place(mission_of(FAR), None, went_home=went_home) == ""
