from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.flight.flying import flown, mission_of, only
from waypointctl.log.messages import Action, Event, EventKind, GroundControl, Observation, State
from waypointctl.policy.bundle import LoadedPolicy, load_policy

REPOSITORY = Path(__file__).parents[2]
PLACES = ({"position_m": [2.0, 1.0]}, {"position_m": [1.0, 3.0]})


@pytest.fixture(scope="module")
def policy() -> LoadedPolicy:
    return load_policy(REPOSITORY / "policies" / "ant-waypoint")


def test_without_delay_a_pilot_walks_as_the_policy_on_board_does_bit_for_bit(policy: LoadedPolicy) -> None:
    on_board = flown(mission_of(*PLACES), policy)
    from_afar = flown(mission_of(*PLACES, autonomy="joint"), policy)
    for kind in (State, Action):
        ours, theirs = only(kind, from_afar[1]), only(kind, on_board[1])
        assert len(ours) == len(theirs) > 50
        for one, other in zip(ours, theirs, strict=True):
            field = "qpos" if kind is State else "applied"
            assert np.array_equal(getattr(one, field), getattr(other, field))
    seen = [control.observation for control in only(GroundControl, from_afar[1])]
    assert np.array_equal(seen, [observation.values for observation in only(Observation, on_board[1])])
    assert from_afar[0].waypoints_reached == 2
    assert from_afar[0].sim_time_ns == on_board[0].sim_time_ns


def test_each_action_is_a_round_trip_old(policy: LoadedPolicy) -> None:
    _, messages = flown(mission_of(*PLACES, autonomy="joint", delay_ms=40.0), policy)
    controls = {control.step: control for control in only(GroundControl, messages)}
    for control in controls.values():
        assert control.time_ns - control.issued_ns == 40_000_000
    driven = [action for action in only(Action, messages) if action.source == "ground"]
    assert driven[0].step == 4, "four control periods of 20 ms after the first state"
    for action in driven:
        assert np.array_equal(action.commanded, controls[action.step - 4].commanded)


def test_a_robot_balanced_from_too_far_falls_and_the_operator_hears_of_it(policy: LoadedPolicy) -> None:
    result, messages = flown(mission_of(*PLACES, autonomy="joint", delay_ms=120.0), policy)
    assert result.outcome == "failure"
    assert result.reason.startswith("fall:")
    (fall,) = [event for event in only(Event, messages) if event.kind is EventKind.FALL]
    assert result.sim_time_ns >= fall.time_ns + 120_000_000


def test_a_scheduled_hold_is_a_hold_until_it_is_resumed(policy: LoadedPolicy) -> None:
    schedule = [{"at_s": 0.5, "do": "hold"}, {"at_s": 3.0, "do": "resume"}]
    result, messages = flown(mission_of(*PLACES, autonomy="joint", schedule=schedule), policy)
    assert result.outcome == "success", result.reason
    stood = [action for action in only(Action, messages) if action.source == "stance"]
    assert len(stood) == 125, "2.5 s"


def test_a_hold_is_kept_by_the_robot_itself(policy: LoadedPolicy) -> None:
    held = PLACES[0] | {"hold_s": 1.0}
    result, messages = flown(mission_of(held, PLACES[1], autonomy="joint"), policy)
    assert result.outcome == "success", result.reason
    sources = [action.source for action in only(Action, messages)]
    first = sources.index("stance")
    assert sources[first : first + 50] == ["stance"] * 50
    assert sources[first + 51] == "ground"


OBSERVED = PLACES[0] | {"hold_s": 1.0, "observe": True}


@pytest.mark.parametrize("delay_ms", [0.0, 10.0])
def test_a_picture_is_taken_by_a_robot_that_stands(policy: LoadedPolicy, delay_ms: float) -> None:
    result, messages = flown(mission_of(OBSERVED, PLACES[1], autonomy="joint", delay_ms=delay_ms), policy)
    assert result.outcome == "success", result.reason
    (taken,) = (event for event in only(Event, messages) if event.kind is EventKind.OBSERVATION_TAKEN)
    assert taken.waypoint == 0
    assert taken.time_ns in {state.time_ns for state in only(State, messages)}, "a picture is made from it"
    sources = {action.time_ns: action.source for action in only(Action, messages)}
    stood = [sources[time_ns] for time_ns in range(taken.time_ns - 2_000_000_000, taken.time_ns, 20_000_000)]
    assert stood == ["stance"] * 100, "the hold of 1 s, and 1 s for the picture"
    assert sources[taken.time_ns + 40_000_000] == "ground", "the pilot goes on"


def test_a_mission_from_the_ground_may_end_with_a_picture(policy: LoadedPolicy) -> None:
    result, messages = flown(mission_of(PLACES[1], OBSERVED, autonomy="joint"), policy)
    assert result.outcome == "success", result.reason
    assert [event.waypoint for event in only(Event, messages) if event.kind is EventKind.OBSERVATION_TAKEN] == [1]


def test_a_picture_that_is_given_up_ends_the_mission(policy: LoadedPolicy) -> None:
    schedule = [{"at_s": 2.0, "do": "abort"}]
    result, messages = flown(mission_of(OBSERVED, PLACES[1], autonomy="joint", schedule=schedule), policy)
    assert result.outcome == "failure"
    assert result.reason.startswith("cancelled by command 2 (abort):")
    assert all(event.kind is not EventKind.OBSERVATION_TAKEN for event in only(Event, messages))


def test_a_hold_at_the_last_waypoint_is_kept_to_its_end(policy: LoadedPolicy) -> None:
    places = (PLACES[0], PLACES[1] | {"hold_s": 3.0})
    on_board = flown(mission_of(*places), policy)[0]
    from_afar, messages = flown(mission_of(*places, autonomy="joint"), policy)
    assert from_afar.outcome == "success", from_afar.reason
    assert from_afar.sim_time_ns == pytest.approx(on_board.sim_time_ns, abs=40_000_000)
    (held,) = (event for event in only(Event, messages) if event.kind is EventKind.HOLD_COMPLETED)
    assert held.time_ns <= from_afar.sim_time_ns


@pytest.mark.parametrize(("does", "reason"), [("return_home", "geofence: "), ("hold", "geofence: the robot is inside")])
def test_a_rule_that_takes_the_motors_is_named_and_a_way_home_is_not_cut_off(
    policy: LoadedPolicy, does: str, reason: str
) -> None:
    fence = {"keep_out": [{"center_m": [4.0, 0.0], "radius_m": 0.5}], "do": does}
    places = ({"position_m": [2.0, 0.0]}, {"position_m": [6.0, 0.0], "timeout_s": 3.0})
    result, messages = flown(mission_of(*places, autonomy="joint", seed=5, onboard={"geofence": fence}), policy)
    kinds = [event.kind for event in only(Event, messages)]
    assert kinds.count(EventKind.RETURN_STARTED) == kinds.count(EventKind.HOME_REACHED) == (does == "return_home")
    assert kinds.index(EventKind.GEOFENCE_BREACHED) < kinds.index(EventKind.WAYPOINT_TIMEOUT)
    assert result.reason.startswith(reason)
    assert ("the robot is at home" in result.reason) == (does == "return_home")


@pytest.mark.parametrize("autonomy", ["joint", "short_range_goal"])
def test_a_robot_that_is_led_goes_home_by_command_and_stays_there(policy: LoadedPolicy, autonomy: str) -> None:
    home = [{"at_s": 0.6, "do": "return_home"}]
    mission = mission_of(*PLACES, autonomy=autonomy, schedule=home, operator={"steering": "continuous"})
    result, messages = flown(mission, policy)
    (home_ns,) = [event.time_ns for event in only(Event, messages) if event.kind is EventKind.HOME_REACHED]
    assert (result.outcome, result.sim_time_ns - home_ns < 1_000_000_000) == ("failure", True)
    assert not [action for action in only(Action, messages) if action.source == "ground" and action.time_ns > home_ns]
