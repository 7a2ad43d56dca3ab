from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from waypointctl.evaluation.walk import Walks, walk
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.seeding import stream
from waypointctl.sim.robots import load_robot
from waypointctl.sim.single import SingleRobot
from waypointctl.task.acceptance import Acceptance
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.body import body_of
from waypointctl.task.config import TaskConfig
from waypointctl.task.course import Deadline
from waypointctl.task.observation import Goals, layout
from waypointctl.task.start import Start

FloatArray = NDArray[np.float64]

TRIALS = 12
SIZE_M = 0.35
FIRST_S, FURTHER_S = 1.5, 1.0
WAYPOINTS = np.array([[0.1, 0.0], [0.45, 0.1]])


def walked_together(policy: LoadedPolicy, ended: Callable[[int], None] = lambda n: None) -> Walks:
    config = TaskConfig(acceptance=Acceptance("radius", SIZE_M), deadline=Deadline(FIRST_S, FURTHER_S))
    env = BatchedWaypointEnv(config, TRIALS, 0, threads=2, max_waypoints=3, autoreset=False)
    env.starts = [stream(0, "walk", i) for i in range(TRIALS)]
    return walk(env, policy, WAYPOINTS, ended)


def walked_alone(policy: LoadedPolicy, trial: int) -> tuple[str, float, float]:
    """Walk one trial in a world of its own; return how it ended, when [s], and how far it walked [m]."""
    robot = load_robot("ant")
    world = SingleRobot(robot)
    qpos, qvel = Start().draw(robot, stream(0, "walk", trial))
    world.place(qpos[np.newaxis], qvel[np.newaxis])
    index, limit_s, walked_m = 0, FIRST_S, 0.0
    for step in range(1, 10_000):
        goal, following = WAYPOINTS[index], WAYPOINTS[min(index + 1, 1)]
        goals = Goals(np.stack([goal, following])[np.newaxis], np.zeros((1, 4)))
        action = policy.act(layout("egocentric").observe(body_of(world.qpos, world.qvel), goals))
        before = world.qpos[0, :2].copy()
        world.step(np.clip(action, -1.0, 1.0))
        x, y, z, _, qx, qy, _ = world.qpos[0, :7]
        walked_m += math.hypot(x - before[0], y - before[1])
        time_s = step * 0.02
        if z < robot.fall_height_m or 1 - 2 * (qx**2 + qy**2) < robot.fall_up:
            return "fall", time_s, walked_m
        if math.hypot(x - goal[0], y - goal[1]) < SIZE_M:
            if index == 1:
                return "success", time_s, walked_m
            index += 1
            limit_s += FURTHER_S
        elif time_s > limit_s - 1e-9:
            return "timeout", time_s, walked_m
    raise AssertionError("the trial did not end")


@pytest.fixture(scope="module")
def policies(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> list[LoadedPolicy]:
    folder: Path = tmp_path_factory.mktemp("policies")
    return [make_policy(folder / f"{seed}", seed=seed, gain=3.0) for seed in range(4)]


def test_side_by_side_each_trial_goes_as_it_goes_alone(policies: list[LoadedPolicy]) -> None:
    seen: set[str] = set()
    for policy in policies:
        walks = walked_together(policy)
        for trial in range(TRIALS):
            end, time_s, walked_m = walked_alone(policy, trial)
            flags = {"success": walks.success[trial], "fall": walks.fell[trial], "timeout": walks.timed_out[trial]}
            assert flags == {name: name == end for name in flags}
            assert walks.time_s[trial] == pytest.approx(time_s, abs=1e-12)
            assert walks.walked_m[trial] == pytest.approx(walked_m, rel=1e-9)
            seen.add(end)
    assert seen == {"success", "fall", "timeout"}, "the policies are too much alike to test the walk"


def test_the_straight_way_leads_from_the_start_through_the_waypoints(policies: list[LoadedPolicy]) -> None:
    walks = walked_together(policies[0])
    np.testing.assert_allclose(walks.straight_m, 0.1 + math.hypot(0.35, 0.1))


def test_spl_is_the_papers_formula() -> None:
    yes, no = np.array([True, True, True, False]), np.zeros(4, bool)
    walked, straight = np.array([10.0, 20.0, 8.0, 10.0]), np.full(4, 10.0)
    assert Walks(yes, no, no, walked, walked, straight).spl == pytest.approx((1.0 + 0.5 + 1.0 + 0.0) / 4)


def test_the_count_of_ended_trials_grows_to_all_of_them(policies: list[LoadedPolicy]) -> None:
    counts: list[int] = []
    walked_together(policies[0], counts.append)
    assert counts == sorted(set(counts))
    assert counts[-1] == TRIALS
