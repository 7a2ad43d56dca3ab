"""Events name the rule that acted."""

from __future__ import annotations

from typing import Any

import pytest

from tests.flight.flying import OUT_OF_REACH, UNDER_FOOT, flown, mission_of, only
from waypointctl.log.messages import Clock, Event, EventKind, Message

FAR = OUT_OF_REACH | {"name": "far"}
SLOW = FAR | {"timeout_s": 20.0}
K = EventKind


def texts(messages: list[Message], *kinds: EventKind) -> list[str]:
    return [event.text for event in only(Event, messages) if event.kind in kinds]


@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "short_range_goal"])
@pytest.mark.parametrize("then", ["abort", "skip", "hold", "return_home"])
def test_a_failed_leg_is_followed_by_the_rule_that_acted(autonomy: str, then: str) -> None:
    home = {"home": {"tolerance_m": 50.0}}
    operator = {"lookahead_m": 100.0}  # under short_range_goal too the leg is one goal
    mission = mission_of(FAR, UNDER_FOOT, autonomy=autonomy, on_failure=then, onboard=home, operator=operator)
    _, messages = flown(mission)
    goal = "towards far" if autonomy == "short_range_goal" else "far"
    skipped = texts(messages, K.WAYPOINT_SKIPPED)
    failed = texts(messages, K.PLAN_FAILED)
    assert skipped == (["far skipped: timeout"] if then == "skip" else [])
    if then == "abort":
        assert failed == ["plan aborted at far: timeout" if autonomy == "mission" else f"{goal} aborted: timeout"]
    elif then == "skip":  # led from the ground, the goal is given up on board, and the ground goes on with the next
        assert failed == ([] if autonomy == "mission" else [f"{goal} aborted: timeout"])
    else:
        assert failed == []
    assert texts(messages, K.SAFE_HOLD_STARTED) == ([f"stopped: leg failed: {goal} timeout"] if then == "hold" else [])
    assert texts(messages, K.RETURN_STARTED) == (["returning home: timeout"] if then == "return_home" else [])


@pytest.mark.parametrize("autonomy", ["waypoint", "short_range_goal"])
def test_what_the_ground_skips_is_on_the_ground_s_clock(autonomy: str) -> None:
    _, messages = flown(mission_of(FAR, UNDER_FOOT, autonomy=autonomy, on_failure="skip", delay_ms=400.0))
    (skipped,) = [event for event in only(Event, messages) if event.kind is K.WAYPOINT_SKIPPED]
    assert (skipped.clock, skipped.waypoint) == (Clock.OPERATOR, 0)


def test_a_command_that_skips_is_named() -> None:
    schedule = [{"at_s": 1.0, "do": "skip"}]
    _, messages = flown(mission_of(SLOW, UNDER_FOOT, schedule=schedule))
    assert texts(messages, K.WAYPOINT_SKIPPED) == ["far skipped: by command 2"]


@pytest.mark.parametrize(
    ("do", "schedule", "lost"),
    [
        ("hold", [], "link lost after 2 s without a message: hold"),
        ("return_home", [], "link lost after 2 s without a message: return_home"),
        ("finish", [], "link lost after 2 s without a message: finish"),
        ("hold", [{"at_s": 1.0, "do": "hold"}], "link lost after 2 s without a message"),
        ("return_home", [{"at_s": 1.0, "do": "return_home"}], "link lost after 2 s without a message"),
        ("finish", [{"at_s": 1.0, "do": "abort"}], "link lost after 2 s without a message"),
    ],
)
def test_a_lost_link_names_its_rule_where_the_rule_changes_something(do: str, schedule: Any, lost: str) -> None:
    onboard = {"link_loss": {"after_s": 2.0, "do": do}, "home": {"position_m": [300.0, 0.0], "timeout_s": 5.0}}
    waits = [*schedule, {"at_s": 8.0, "do": "hold"}]
    _, messages = flown(mission_of(SLOW, onboard=onboard, schedule=waits))
    assert texts(messages, K.LINK_LOST)[0] == lost


@pytest.mark.parametrize(
    ("do", "then"), [("hold", K.SAFE_HOLD_STARTED), ("abort", K.PLAN_FAILED), ("return_home", K.RETURN_STARTED)]
)
def test_a_breach_of_the_fence_is_followed_by_its_rule(do: str, then: EventKind) -> None:
    fence = {"keep_out": [{"name": "rock", "center_m": [0.0, 0.0], "radius_m": 5.0}], "do": do}
    _, messages = flown(mission_of(FAR, on_failure="skip", onboard={"geofence": fence, "home": {"tolerance_m": 50.0}}))
    (said,) = texts(messages, K.SAFE_HOLD_STARTED, K.PLAN_FAILED, K.RETURN_STARTED, K.WAYPOINT_SKIPPED)
    assert (
        said
        == {
            "hold": "stopped: geofence: the robot is inside keep-out rock",
            "abort": "plan aborted at far: geofence",
            "return_home": "returning home: geofence",
        }[do]
    )
    assert [event.kind for event in only(Event, messages) if event.text == said] == [then]


def test_a_way_home_that_fails_is_no_plan() -> None:
    onboard = {"home": {"position_m": [300.0, 0.0], "timeout_s": 1.0}}
    _, messages = flown(mission_of(FAR, on_failure="return_home", onboard=onboard))
    assert texts(messages, K.RETURN_FAILED) == ["return home aborted: timeout"]
    assert texts(messages, K.PLAN_FAILED) == []
