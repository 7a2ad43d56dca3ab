"""Masses, friction and gravity of single robots of a batch, against bare models changed the same way."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.sim.bare import BareWorld, random_start
from waypointctl.robots.load import load_robot
from waypointctl.sim.stepping import RobotBatch

FloatArray = NDArray[np.float64]

ROBOTS = 5
ALL = np.arange(ROBOTS)


def heavier(world: BareWorld, factor: float) -> None:
    for body in range(world.model.nbody):
        world.model.body_mass[body] *= factor
        world.model.body_inertia[body] *= factor
    mujoco.mj_setConst(world.model, mujoco.MjData(world.model))


def rougher(world: BareWorld, factor: float) -> None:
    for geom in range(world.model.ngeom):
        world.model.geom_friction[geom, 0] *= factor


def on_a_moon(world: BareWorld, gravity_mps2: float) -> None:
    world.model.opt.gravity = [0.0, 0.0, -gravity_mps2]


def started(batch: RobotBatch, seed: int) -> list[BareWorld]:
    """Place every robot of a batch and return worlds in which they stand alike."""
    rng = np.random.default_rng(seed)
    starts = [random_start(rng) for _ in range(batch.qpos.shape[0])]
    batch.place(np.arange(len(starts)), *(np.stack(part) for part in zip(*starts, strict=True)))
    worlds = [BareWorld() for _ in starts]
    for world, start in zip(worlds, starts, strict=True):
        world.place(*start)
    return worlds


def hold_together(batch: RobotBatch, worlds: list[BareWorld], steps: int, seed: int = 0) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(steps):
        applied = rng.uniform(-1.0, 1.0, (len(worlds), 8))
        batch.step(applied)
        for i, world in enumerate(worlds):
            world.step(applied[i])
            np.testing.assert_array_equal(batch.integration[i], world.integration)


CHANGES = [
    (RobotBatch.scale_mass, heavier, (0.3, 4.0)),
    (RobotBatch.scale_friction, rougher, (0.05, 3.0)),
    (RobotBatch.set_gravity, on_a_moon, (0.0, 25.0)),
]


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(("change", "oracle", "between"), CHANGES, ids=["mass", "friction", "gravity"])
def test_each_robot_goes_as_a_bare_model_changed_the_same_way(
    change: Callable[[RobotBatch, NDArray[np.intp], FloatArray], None],
    oracle: Callable[[BareWorld, float], None],
    between: tuple[float, float],
    threads: int,
) -> None:
    batch = RobotBatch(load_robot("ant"), ROBOTS, threads)
    values = np.random.default_rng(1).uniform(*between, ROBOTS)
    change(batch, ALL, values)
    worlds = started(batch, 2)
    for world, value in zip(worlds, values, strict=True):
        oracle(world, value)
    hold_together(batch, worlds, 150)


def test_all_at_once_on_some_robots_in_any_order_and_anew() -> None:
    batch = RobotBatch(load_robot("ant"), ROBOTS)
    batch.scale_mass(ALL, np.full(ROBOTS, 9.0))
    batch.scale_mass(np.array([0, 2, 4]), np.ones(3))
    for ids, value in ((np.array([3, 1]), 1.5), (np.array([3, 1]), 0.7)):
        batch.scale_mass(ids, np.array([value, value + 1.0]))
        batch.scale_friction(ids, np.array([value, value + 2.0]))
        batch.set_gravity(ids, np.array([value, value + 3.0]))
    worlds = started(batch, 3)
    for robot, value in ((3, 0.0), (1, 1.0)):
        heavier(worlds[robot], 0.7 + value)
        rougher(worlds[robot], 0.7 + 2 * value)
        on_a_moon(worlds[robot], 0.7 + 3 * value)
    hold_together(batch, worlds, 100)


def test_a_placed_robot_keeps_its_dynamics() -> None:
    batch = RobotBatch(load_robot("ant"), 2)
    batch.set_gravity(np.array([1]), np.array([1.62]))
    for seed in (4, 5):
        worlds = started(batch, seed)
        on_a_moon(worlds[1], 1.62)
        hold_together(batch, worlds, 20)


def test_two_physics_steps_are_a_control_period() -> None:
    batch = RobotBatch(load_robot("ant"), ROBOTS)
    worlds = started(batch, 6)
    rng = np.random.default_rng(7)
    for _ in range(50):
        for _ in range(2):
            applied = rng.uniform(-1.0, 1.0, (ROBOTS, 8))
            batch.step_physics(applied)
            for i, world in enumerate(worlds):
                world.data.ctrl[:] = applied[i]
                mujoco.mj_step(world.model, world.data)
        for i, world in enumerate(worlds):
            np.testing.assert_array_equal(batch.integration[i], world.integration)


def high_up(batch: RobotBatch) -> None:
    robot = load_robot("ant")
    robots = batch.qpos.shape[0]
    qpos = np.tile(np.concatenate([[0.0, 0.0, 50.0, 1.0, 0.0, 0.0, 0.0], robot.nominal]), (robots, 1))
    batch.place(np.arange(robots), qpos, np.zeros((robots, 14)))


def test_all_masses_fall_alike_and_each_gravity_as_galileo_says() -> None:
    batch = RobotBatch(load_robot("ant"), 3)
    batch.scale_mass(np.array([1]), np.array([3.0]))
    batch.set_gravity(np.array([2]), np.array([1.62]))
    high_up(batch)
    for _ in range(25):
        batch.step(np.zeros((3, 8)))
    # Semi-implicit Euler falls g h^2 n (n + 1) / 2 in n steps of h.
    expected_m = np.array([9.81, 9.81, 1.62]) * 0.01**2 * 50 * 51 / 2
    np.testing.assert_allclose(50.0 - batch.qpos[:, 2], expected_m, rtol=1e-9)


def test_the_same_push_of_the_legs_lifts_a_heavier_robot_less() -> None:
    batch = RobotBatch(load_robot("ant"), 2)
    batch.scale_mass(np.array([1]), np.array([3.0]))
    robot = load_robot("ant")
    qpos = np.tile(np.concatenate([[0, 0, robot.nominal_height_m, 1, 0, 0, 0], robot.nominal]), (2, 1))
    batch.place(np.arange(2), qpos, np.zeros((2, 14)))
    highest_m = np.zeros(2)
    for _ in range(25):
        batch.step(np.tile([0.0, 1.0], (2, 4)))
        highest_m = np.maximum(highest_m, batch.qpos[:, 2])
    assert highest_m[0] > highest_m[1]


def test_a_robot_slides_as_far_as_its_friction_lets_it() -> None:
    """Sliding without rolling stops after v^2 / (2 mu g); the ant's legs fold, so only the order is held."""
    batch = RobotBatch(load_robot("ant"), 3)
    batch.scale_friction(np.arange(3), np.array([0.1, 0.3, 1.0]))
    robot = load_robot("ant")
    qpos = np.tile(np.concatenate([[0, 0, robot.nominal_height_m, 1, 0, 0, 0], robot.nominal]), (3, 1))
    qvel = np.zeros((3, 14))
    qvel[:, 0] = 1.0
    batch.place(np.arange(3), qpos, qvel)
    for _ in range(100):
        batch.step(np.zeros((3, 8)))
    slid_m = batch.qpos[:, 0]
    assert slid_m[0] > slid_m[1] > slid_m[2] > 0
