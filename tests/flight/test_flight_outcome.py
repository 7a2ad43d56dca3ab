from __future__ import annotations

from typing import Any

import pytest

from tests.flight.flying import (
    MS,
    OUT_OF_REACH,
    TUMBLE,
    UNDER_FOOT,
    Scripted,
    flown,
    mission_of,
    only,
    times_ns,
)
from waypointctl.log.messages import (
    Action,
    Event,
    EventKind,
    Reward,
    State,
)


def test_a_flight_succeeds_when_all_is_reached_in_time() -> None:
    result, _ = flown(mission_of(UNDER_FOOT, UNDER_FOOT, expect={"max_time_s": 5.0}))
    assert (result.outcome, result.waypoints_reached, result.waypoints_total) == ("success", 2, 2)


def test_a_waypoint_out_of_reach_fails_the_mission() -> None:
    result, messages = flown(mission_of(UNDER_FOOT, OUT_OF_REACH, UNDER_FOOT, delay_ms=40.0))
    assert (result.outcome, result.waypoints_reached) == ("failure", 1)
    assert result.reason.startswith("timeout: 1 of 3 waypoints reached in 1.10 s")
    assert times_ns(EventKind.WAYPOINT_TIMEOUT, messages) == [1060 * MS]
    assert times_ns(EventKind.PLAN_FAILED, messages) == [1060 * MS]


@pytest.mark.parametrize("autonomy", ["mission", "waypoint"])
@pytest.mark.parametrize(("expected", "outcome"), [(2, "success"), ("all", "failure")])
def test_a_skipped_waypoint_is_weighed_against_what_is_expected(
    autonomy: str, expected: int | str, outcome: str
) -> None:
    mission = mission_of(
        UNDER_FOOT,
        OUT_OF_REACH,
        UNDER_FOOT,
        on_failure="skip",
        autonomy=autonomy,
        expect={"reached": expected},
        delay_ms=60.0,
    )
    result, messages = flown(mission)
    assert (result.outcome, result.waypoints_reached) == (outcome, 2)
    reached = [e.waypoint for e in only(Event, messages) if e.kind is EventKind.WAYPOINT_REACHED]
    assert reached == [0, 2]
    if autonomy == "mission":
        assert len(times_ns(EventKind.WAYPOINT_SKIPPED, messages)) == 1


@pytest.mark.parametrize("autonomy", ["mission", "waypoint"])
def test_a_fall_ends_the_mission_when_the_operator_hears_of_it(autonomy: str) -> None:
    far = OUT_OF_REACH | {"timeout_s": 10.0}
    mission = mission_of(far, far, autonomy=autonomy, delay_ms=250.0, expect={"reached": 0})
    result, messages = flown(mission, Scripted(TUMBLE))
    (fell,) = times_ns(EventKind.FALL, messages)
    assert result.outcome == "failure"
    assert result.reason.startswith("fall: 0 of 2")
    assert result.sim_time_ns == fell + 250 * MS
    sources = [(action.time_ns >= fell, action.source) for action in only(Action, messages)]
    assert {source for after, source in sources if after} == {"off"}
    assert {source for after, source in sources if not after} == {"stance", "policy"}


def test_a_fall_is_paid_for_once_and_lying_down_earns_nothing() -> None:
    _, messages = flown(mission_of(OUT_OF_REACH | {"timeout_s": 10.0}, delay_ms=250.0), Scripted(TUMBLE))
    (fell,) = times_ns(EventKind.FALL, messages)
    paid = {reward.time_ns: dict(reward.terms)["fall"] for reward in only(Reward, messages)}
    assert {time for time, fall in paid.items() if fall} == {fell}
    assert paid[fell] == -200.0
    lying = [reward for reward in only(Reward, messages) if reward.time_ns > fell]
    assert len(lying) > 5
    assert {value for reward in lying for value in (reward.total, *dict(reward.terms).values())} == {0.0}


def test_a_mission_that_takes_too_long_is_ended() -> None:
    mission = mission_of(OUT_OF_REACH | {"timeout_s": 60.0}, expect={"max_time_s": 2.0})
    result, messages = flown(mission)
    assert result.outcome == "failure"
    assert result.reason.startswith("the mission took longer than 2 s: 0 of 1")
    assert only(State, messages)[-1].time_ns == 2020 * MS


def test_success_that_is_heard_of_too_late_is_no_success() -> None:
    result, _ = flown(mission_of(UNDER_FOOT, delay_ms=1000.0, expect={"max_time_s": 2.01}))
    assert result.outcome == "failure"
    result, _ = flown(mission_of(UNDER_FOOT, delay_ms=1000.0, expect={"max_time_s": 2.02}))
    assert result.outcome == "success"


@pytest.mark.parametrize(
    ("expect", "said"),
    [
        ({}, "timeout: 1 of 2 waypoints reached, 2 expected; "),
        ({"max_time_s": 3.0}, "the mission took longer than 3 s: 1 of 2 waypoints reached; "),
    ],
)
def test_a_flight_that_goes_on_after_its_plan_names_both_times(expect: dict[str, Any], said: str) -> None:
    home = {"home": {"position_m": [5.0, 0.0], "timeout_s": 4.0}}
    then: dict[str, Any] = {"on_failure": "return_home", "onboard": home, "delay_ms": 250.0}
    result, _ = flown(mission_of(UNDER_FOOT, OUT_OF_REACH, expect=expect, **then))
    known_s, ended_s = result.known_ns / 1e9, result.sim_time_ns / 1e9
    assert ended_s > known_s + 1.0
    times = f"the operator received the end of the plan at {known_s:.2f} s; the flight ended at {ended_s:.2f} s"
    assert result.reason.startswith(said + times)
