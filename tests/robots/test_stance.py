from __future__ import annotations

import numpy as np
import pytest

from tests.sim.bare import BareWorld
from waypointctl.robots.load import load_robot
from waypointctl.robots.robot import stance_action


def stand(world: BareWorld, seconds: float) -> float:
    """Stand for a while; return the smallest upward part of the torso's axis on the way."""
    robot, least = load_robot("ant"), 1.0
    for _ in range(round(seconds / 0.02)):
        action = stance_action(robot, world.data.qpos[np.newaxis], world.data.qvel[np.newaxis])
        world.step(np.clip(action[0], -1.0, 1.0))
        least = min(least, float(world.data.body("torso").xmat[8]))
    return least


def standing(speed_mps: float = 0.0, direction_rad: float = 0.0) -> BareWorld:
    robot, world = load_robot("ant"), BareWorld()
    qvel = np.zeros(14)
    qvel[:2] = speed_mps * np.cos(direction_rad), speed_mps * np.sin(direction_rad)
    world.place(np.array([0.0, 0.0, robot.nominal_height_m, 1.0, 0.0, 0.0, 0.0, *robot.nominal]), qvel)
    return world


def test_is_a_spring_and_a_damper_at_each_joint() -> None:
    robot, rng = load_robot("ant"), np.random.default_rng(0)
    qpos, qvel = rng.normal(size=(3, 15)), rng.normal(size=(3, 14))
    action = stance_action(robot, qpos, qvel)
    for i in range(3):
        for j in range(8):
            spring = robot.description.stance.stiffness * (robot.nominal[j] - qpos[i, 7 + j])
            assert action[i, j] == pytest.approx(spring - robot.description.stance.damping * qvel[i, 6 + j])


def test_keeps_standing_for_a_minute() -> None:
    world = standing()
    assert stand(world, 60.0) > 0.99
    robot = load_robot("ant")
    assert world.data.qpos[2] == pytest.approx(robot.nominal_height_m, abs=0.03)
    np.testing.assert_allclose(world.data.qpos[7:], robot.nominal, atol=0.1)
    assert np.hypot(*world.data.qpos[:2]) < 0.05
    assert np.abs(world.data.qvel).max() < 1e-3


@pytest.mark.parametrize("direction_deg", [0.0, 45.0, 90.0, 200.0])
def test_brakes_from_three_metres_a_second_without_falling(direction_deg: float) -> None:
    world = standing(3.0, np.deg2rad(direction_deg))
    robot = load_robot("ant")
    assert stand(world, 3.0) > robot.min_up
    assert np.hypot(*world.data.qvel[:2]) < 0.02
    assert world.data.qpos[2] > robot.min_height_m
