from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pydantic import ValidationError

from tests.task.views import ANT, view_of
from waypointctl.task.reward import TERMS as BUILT_IN
from waypointctl.task.reward import JointLimits, RewardFunction, RewardWeights, progress_speed

FloatArray = NDArray[np.float64]

TERMS = tuple(term.name for term in BUILT_IN)
ALL_ONE = RewardWeights(
    progress=1.0,
    alive=1.0,
    power=1.0,
    torque=1.0,
    joint_limits=1.0,
    orientation_penalty=1.0,
    angular_rate_penalty=1.0,
    fall=1.0,
)


def terms_of(
    weights: RewardWeights = ALL_ONE,
    *,
    approach: float = 0.0,
    applied: FloatArray | None = None,
    joint_rates: FloatArray | None = None,
    rates: tuple[float, float, float] = (0.0, 0.0, 0.0),
    tilt_rad: float = 0.0,
    at_limit: int = 0,
    fell: bool = False,
) -> dict[str, float]:
    quaternion = [math.cos(tilt_rad / 2), 0.6 * math.sin(tilt_rad / 2), 0.8 * math.sin(tilt_rad / 2), 0.0]
    joints = ANT.nominal.copy()
    joints[:at_limit] = ANT.joint_high[:at_limit]
    qpos = np.array([[0.0, 0.0, 0.5, *quaternion, *joints]])
    qvel = np.array([[0.0, 0.0, 0.0, *rates, *(np.zeros(8) if joint_rates is None else joint_rates)]])
    action = np.zeros((1, 8)) if applied is None else applied[np.newaxis]
    view = view_of(qpos, qvel, action=action, approach=np.array([approach]), fell=np.array([fell]))
    reward = RewardFunction(weights)
    assert reward.names == TERMS
    terms = reward.terms(view)
    assert terms.shape == (1, len(TERMS))
    return dict(zip(TERMS, terms[0].tolist(), strict=True))


def test_standing_still_and_upright_pays_only_for_being_alive() -> None:
    assert terms_of() == pytest.approx({name: float(name == "alive") for name in TERMS})


def test_progress_is_the_speed_of_approach_up_to_the_cap() -> None:
    assert terms_of(approach=3.0)["progress"] == 3.0
    assert terms_of(approach=-3.0)["progress"] == -3.0
    capped = ALL_ONE.model_copy(update={"progress": 2.0, "progress_cap_mps": 1.5})
    assert terms_of(capped, approach=1.4)["progress"] == 2.8
    assert terms_of(capped, approach=7.0)["progress"] == 3.0
    assert terms_of(capped, approach=-7.0)["progress"] == -14.0, "what is capped is pay, never cost"


def test_power_is_roboschools_electricity_cost() -> None:
    rng = np.random.default_rng(0)
    applied, rates = rng.uniform(-1, 1, 8), rng.normal(size=8) * 10
    expected = -2.0 * sum(abs(a * 0.1 * w) for a, w in zip(applied, rates, strict=True)) / 8
    found = terms_of(ALL_ONE.model_copy(update={"power": 2.0}), applied=applied, joint_rates=rates)
    assert found["power"] == pytest.approx(expected)


def test_torque_is_roboschools_stall_cost() -> None:
    applied = np.array([1.0, -1.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.25])
    expected = -0.1 * (1 + 1 + 0.25 + 0.0625) / 8
    assert terms_of(ALL_ONE.model_copy(update={"torque": 0.1}), applied=applied)["torque"] == pytest.approx(expected)


def test_each_joint_at_its_limit_costs() -> None:
    assert terms_of(ALL_ONE.model_copy(update={"joint_limits": 0.2}), at_limit=3)["joint_limits"] == pytest.approx(-0.6)


@pytest.mark.parametrize(("tilt_deg", "cost"), [(0, 0.0), (60, 0.5), (90, 1.0), (180, 2.0)])
def test_tilt_costs_from_0_upright_to_2_upside_down(tilt_deg: float, cost: float) -> None:
    assert terms_of(tilt_rad=math.radians(tilt_deg))["orientation_penalty"] == pytest.approx(-cost)


def test_angular_rate_penalty_is_of_roll_and_pitch_rates_but_not_turning() -> None:
    assert terms_of(rates=(3.0, -4.0, 100.0))["angular_rate_penalty"] == pytest.approx(-25.0)


def test_a_fall_costs_and_is_not_alive() -> None:
    weights = ALL_ONE.model_copy(update={"alive": 0.5, "fall": 200.0})
    assert (terms_of(weights)["alive"], terms_of(weights)["fall"]) == (0.5, 0.0)
    fallen = terms_of(weights, fell=True)
    assert (fallen["alive"], fallen["fall"]) == (0.0, -200.0)


def test_a_weight_of_nought_makes_its_term_nought() -> None:
    nothing = RewardWeights(**dict.fromkeys(TERMS, 0.0))
    rng = np.random.default_rng(1)
    terms = terms_of(
        nothing,
        approach=2.0,
        applied=rng.normal(size=8),
        joint_rates=rng.normal(size=8),
        rates=(1.0, 2.0, 3.0),
        tilt_rad=1.0,
        at_limit=4,
        fell=True,
    )
    assert terms == pytest.approx(dict.fromkeys(TERMS, 0.0))


def test_a_joint_is_at_its_limit_within_one_per_cent_of_its_range_or_past_it() -> None:
    low, high = np.array([-1.0, 0.0]), np.array([1.0, 10.0])
    limits = JointLimits.of_range(low, high)
    joints = np.array([[0.0, 5.0], [-0.981, 5.0], [-0.979, 5.0], [-1.2, 9.91], [0.0, 9.89], [0.981, 0.09], [2.0, 0.2]])
    assert limits.count(joints).tolist() == [0.0, 1.0, 0.0, 2.0, 0.0, 2.0, 1.0]


@given(
    st.lists(st.tuples(*[st.floats(-50, 50)] * 2), min_size=2, max_size=30),
    st.tuples(*[st.floats(-50, 50)] * 2),
)
@settings(max_examples=200, deadline=None)
def test_progress_telescopes_to_the_distance_that_was_gained(
    path: list[tuple[float, float]], goal: tuple[float, float]
) -> None:
    places, goals = np.array(path), np.tile(np.array(goal), (len(path) - 1, 1))
    speeds = progress_speed(places[:-1], places[1:], goals, 0.02)
    gained = math.dist(path[0], goal) - math.dist(path[-1], goal)
    assert speeds.sum() * 0.02 == pytest.approx(gained, abs=1e-9)


def test_walking_straight_at_the_goal_makes_progress_at_walking_speed() -> None:
    before, after = np.array([[0.0, 0.0], [0.0, 0.0]]), np.array([[0.03, 0.04], [-0.04, 0.03]])
    speed = progress_speed(before, after, np.array([[3.0, 4.0], [3.0, 4.0]]), 0.02)
    assert speed[0] == pytest.approx(2.5)
    assert speed[1] == pytest.approx(0.0, abs=0.02)


@pytest.mark.parametrize("field", list(RewardWeights.model_fields))
@pytest.mark.parametrize("value", [-0.1, math.nan])
def test_a_weight_that_would_pay_for_a_cost_is_refused(field: str, value: float) -> None:
    with pytest.raises(ValidationError):
        RewardWeights.model_validate({field: value})
