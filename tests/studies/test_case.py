from __future__ import annotations

import pytest

from tests.studies.standing import here
from waypointctl.studies.case import AUTONOMIES, FINE_RTTS_S, DelayCase, fine_grid, grid, load_route, mission_of


def test_every_combination_is_flown_once() -> None:
    cases = grid(["a", "b"], ["mission", "joint"], [0.0, 5.0], range(3))
    assert len(cases) == len(set(cases)) == 24
    assert cases[:4] == [DelayCase("a", "mission", 0.0, seed) for seed in range(3)] + [
        DelayCase("a", "mission", 5.0, 0)
    ]


def test_the_finer_sweep_goes_to_beyond_a_quarter_of_a_second_in_steps_of_20_ms() -> None:
    assert FINE_RTTS_S == (0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.14, 0.16, 0.18, 0.2, 0.22, 0.24, 0.26)
    assert fine_grid(["a"], [1]) == [DelayCase("a", "joint", rtt_s, 1) for rtt_s in FINE_RTTS_S]


@pytest.mark.parametrize("name", AUTONOMIES)
def test_a_case_is_the_route_with_its_delay_autonomy_and_seed(name: str) -> None:
    route = load_route("ten-point").mission
    mission = mission_of(route, DelayCase("ten-point", name, 2.56, 7), think_s=1.5)
    autonomy = AUTONOMIES[name]
    assert (mission.link.up.delay_s, mission.link.down.delay_s) == (1.28, 1.28)
    assert mission.link.up.jitter_s == mission.link.down.jitter_s == 0
    assert mission.link.up.loss == mission.link.down.loss == 0
    assert (mission.seed, mission.autonomy) == (7, autonomy.level)
    assert (mission.operator.steering, mission.operator.think_s) == (autonomy.steering, 1.5)
    assert [leg.x_m for leg in mission.legs()] == [leg.x_m for leg in route.legs()]
    assert type(mission).model_validate(mission.model_dump()) == mission


def test_time_limits_leave_an_operator_time_for_every_short_range_goal() -> None:
    route = load_route("two-point").mission
    mission = mission_of(route, DelayCase("two-point", "short_range_goal", 40.0, 0), think_s=10.0)
    goals = 13.9 / 1.5  # a goal 2 m ahead is reached half a metre before it
    assert all(leg.timeout_s > 60 + goals * 50 for leg in mission.legs())
    assert mission.expect.max_time_s is not None
    assert mission.expect.max_time_s >= sum(leg.timeout_s for leg in mission.legs())


def test_limits_stay_within_what_a_mission_may_have() -> None:
    mission = mission_of(here().mission, DelayCase("here", "waypoint", 86_400.0, 0), think_s=86_400.0)
    assert type(mission).model_validate(mission.model_dump()) == mission
