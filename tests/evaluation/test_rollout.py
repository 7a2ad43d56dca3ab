from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.task.views import ant_layout, view_of
from waypointctl.evaluation.rollout import Rollouts, rollout
from waypointctl.evaluation.suite import Hold
from waypointctl.mission.fields import Acceptance, Start
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.robots.load import load_robot
from waypointctl.robots.robot import stance_action
from waypointctl.seeding import stream
from waypointctl.sim.stepping import SingleRobot
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import TaskConfig, draw_start
from waypointctl.task.course import Deadline

FloatArray = NDArray[np.float64]

TRIALS = 8
SIZE_M = 0.35
FIRST_S, FURTHER_S = 1.5, 1.0
WITHIN_M = 0.4
HOLD_STEPS = 15
HOLD = Hold(time_s=0.3, within_m=WITHIN_M)
PATHS = [np.array([[0.1, 0.0], [0.45, 0.1]]), np.array([[0.1, 0.4]])] * (TRIALS // 2)


def walked_together(
    policy: LoadedPolicy, hold: Hold | None = None, ended: Callable[[int], None] = lambda n: None
) -> Rollouts:
    config = TaskConfig(
        acceptance=Acceptance(shape="radius", size_m=SIZE_M), deadline=Deadline(first_s=FIRST_S, further_s=FURTHER_S)
    )
    env = BatchedWaypointEnv(config, TRIALS, 0, threads=2, max_waypoints=3, autoreset=False)
    env.starts = [stream(0, "walk", i) for i in range(TRIALS)]
    return rollout(env, policy, PATHS, ended, hold)


@dataclass
class Alone:
    """One trial in a world of its own."""

    end: str
    time_s: float = 0.0
    path_m: float = 0.0
    legs: int = 0
    way: list[FloatArray] = field(default_factory=list)  # (2,) after each control step


def held(distance: float, standing: int) -> str:
    """Return how a hold ends after `standing` - 1 control steps at this distance, "" if it goes on."""
    return "strayed" if distance > WITHIN_M else "success" if standing == 1 + HOLD_STEPS else ""


def walked_alone(policy: LoadedPolicy, trial: int, hold: Hold | None = None) -> Alone:
    robot, path = load_robot("ant"), PATHS[trial]
    world = SingleRobot(robot)
    qpos, qvel = draw_start(Start(), robot, stream(0, "walk", trial))
    world.place(qpos[np.newaxis], qvel[np.newaxis])
    found, limit_s, standing = Alone("", way=[world.qpos[0, :2].copy()]), FIRST_S, 0
    for step in range(1, 10_000):
        goal, following = path[min(found.legs, len(path) - 1)], path[min(found.legs + 1, len(path) - 1)]
        view = view_of(world.qpos, world.qvel, np.stack([goal, following])[np.newaxis])
        action = policy.act(ant_layout("egocentric").observe(view))
        if standing:
            action = stance_action(robot, world.qpos, world.qvel)
        before = world.qpos[0, :2].copy()
        world.step(np.clip(action, -1.0, 1.0))
        x, y, z, _, qx, qy, _ = world.qpos[0, :7]
        found.way.append(world.qpos[0, :2].copy())
        if not standing:
            found.path_m += math.hypot(x - before[0], y - before[1])
            found.time_s = step * 0.02
        distance = math.hypot(x - goal[0], y - goal[1])
        if z < robot.min_height_m or 1 - 2 * (qx**2 + qy**2) < robot.min_up:
            found.end = "fell"
        elif standing:
            standing += 1
            found.end = held(distance, standing)
        elif distance < SIZE_M:
            found.legs += 1
            limit_s += FURTHER_S
            if found.legs == len(path):
                standing = 1
                found.end = "success" if hold is None else held(distance, standing)
        elif found.time_s > limit_s - 1e-9:
            found.end = "timed_out"
        if found.end:
            return found
    raise AssertionError("the trial did not end")


@pytest.fixture(scope="module")
def policies(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> list[LoadedPolicy]:
    folder: Path = tmp_path_factory.mktemp("policies")
    return [make_policy(folder / f"{seed}", seed=seed, gain=3.0) for seed in range(4)]


ENDS = ("success", "fell", "timed_out", "strayed")


@pytest.mark.parametrize("hold", [None, HOLD])
def test_side_by_side_each_trial_goes_as_it_goes_alone(policies: list[LoadedPolicy], hold: Hold | None) -> None:
    seen: set[str] = set()
    for policy in policies:
        rollouts = walked_together(policy, hold)
        for trial in range(TRIALS):
            alone = walked_alone(policy, trial, hold)
            assert {name: bool(getattr(rollouts, name)[trial]) for name in ENDS} == {
                name: name == alone.end for name in ENDS
            }
            assert rollouts.time_s[trial] == pytest.approx(alone.time_s, abs=1e-12)
            assert rollouts.path_m[trial] == pytest.approx(alone.path_m, rel=1e-9)
            assert (rollouts.legs[trial], rollouts.legs_reached[trial]) == (len(PATHS[trial]), alone.legs)
            np.testing.assert_array_equal(rollouts.trajectories[trial], [*alone.way[::5], alone.way[-1]])
            seen.add(alone.end)
    assert seen == set(ENDS if hold else ENDS[:3]), "the policies are too much alike to test the walk"


def test_the_straight_way_leads_from_the_start_through_the_waypoints(policies: list[LoadedPolicy]) -> None:
    rollouts = walked_together(policies[0])
    np.testing.assert_allclose(rollouts.straight_m[[0, 1]], [0.1 + math.hypot(0.35, 0.1), math.hypot(0.1, 0.4)])
    assert [len(path) for path in rollouts.paths[:2]] == [2, 1]


def test_spl_is_the_papers_formula(policies: list[LoadedPolicy]) -> None:
    rollouts = walked_together(policies[0])
    made = replace(
        rollouts,
        success=np.array([True, True, True, False]),
        path_m=np.array([10.0, 20.0, 8.0, 10.0]),
        straight_m=np.full(4, 10.0),
    )
    assert made.spl == pytest.approx((1.0 + 0.5 + 1.0 + 0.0) / 4)


def test_the_count_of_ended_trials_grows_to_all_of_them(policies: list[LoadedPolicy]) -> None:
    counts: list[int] = []
    walked_together(policies[0], ended=counts.append)
    assert counts == sorted(set(counts))
    assert counts[-1] == TRIALS
