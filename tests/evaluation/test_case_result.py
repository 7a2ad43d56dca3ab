from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from waypointctl.evaluation.evaluate import case_result
from waypointctl.evaluation.rollout import Rollouts
from waypointctl.evaluation.suite import Case, RandomPaths

NOBODY = np.zeros(6, bool)
# Two successes, a fall on the second leg, an orbit on the first, one that is late on the third, one that strays.
WALKS = Rollouts(
    success=np.array([True, True, False, False, False, False]),
    fell=np.array([False, False, True, False, False, False]),
    timed_out=np.array([False, False, False, True, True, False]),
    strayed=np.array([False, False, False, False, False, True]),
    orbiting=np.array([False, False, False, True, False, False]),
    stuck=NOBODY,
    time_s=np.array([10.0, 20.0, 7.0, 10.0, 50.0, 12.0]),
    path_m=np.array([20.0, 25.0, 9.0, 9.0, 9.0, 9.0]),
    straight_m=np.full(6, 20.0),
    legs=np.full(6, 3),
    legs_reached=np.array([3, 3, 1, 0, 2, 3]),
    legs_time_s=np.array([10.0, 20.0, 5.0, 0.0, 13.0, 12.0]),
    paths=(),
    trajectories=(),
)


def test_every_trial_is_in_one_of_the_counts() -> None:
    found = case_result(RandomPaths(name="a"), WALKS)
    counts = (found.successes, found.falls, found.timeouts, found.strayed, found.trials)
    assert counts == (2, 1, 2, 1, 6)
    assert (found.orbiting, found.stuck, found.late) == (1, 0, 1)


def test_times_and_speed_are_of_the_successes() -> None:
    found = case_result(RandomPaths(name="a"), WALKS)
    assert found.mean_time_s == 15.0
    assert found.mean_speed_mps == 45.0 / 30.0
    assert found.spl == pytest.approx((1.0 + 0.8) / 6)


def test_legs_are_those_that_were_set_out_on() -> None:
    found = case_result(RandomPaths(name="a"), WALKS)
    assert (found.legs_reached, found.legs) == (12, 15)  # the fall's second, the orbit's first, the late one's third
    assert found.mean_leg_time_s == 60.0 / 12


def test_where_nothing_is_reached_there_are_no_means() -> None:
    lost = replace(WALKS, success=NOBODY, legs_reached=np.zeros(6, int))
    found = case_result(Case(name="a", waypoints=((1.0, 2.0),), paper=0.5), lost)
    assert (found.mean_time_s, found.mean_speed_mps, found.mean_leg_time_s, found.legs) == (None, None, None, 6)
    assert (found.waypoints, found.paper, found.course) == (((1.0, 2.0),), 0.5, None)
