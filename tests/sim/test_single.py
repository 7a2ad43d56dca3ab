from __future__ import annotations

import mujoco
import numpy as np

from tests.sim.bare import INTEGRATION, BareWorld, random_start
from waypointctl.robots.load import load_robot
from waypointctl.sim.stepping import SingleRobot, integration_components


def test_goes_as_a_bare_mj_step_loop_with_resets() -> None:
    rng = np.random.default_rng(0)
    single, world = SingleRobot(load_robot("ant")), BareWorld()
    for step in range(500):
        if step % 90 == 0:
            qpos, qvel = random_start(rng)
            single.place(qpos[np.newaxis], qvel[np.newaxis])
            world.place(qpos, qvel)
        applied = rng.uniform(-1.0, 1.0, (1, 8))
        single.step(applied)
        world.step(applied[0])
        np.testing.assert_array_equal(single.integration_state(), world.integration)
        np.testing.assert_array_equal(single.qpos[0], world.data.qpos)
        np.testing.assert_array_equal(single.qvel[0], world.data.qvel)
        np.testing.assert_array_equal(single.qacc_warmstart[0], world.data.qacc_warmstart)


def test_goes_on_exactly_from_a_state_it_gave() -> None:
    rng = np.random.default_rng(1)
    first, second = SingleRobot(load_robot("ant")), SingleRobot(load_robot("ant"))
    qpos, qvel = random_start(rng)
    first.place(qpos[np.newaxis], qvel[np.newaxis])
    for _ in range(50):
        first.step(rng.uniform(-1.0, 1.0, (1, 8)))
    kept = first.integration_state()
    mujoco.mj_setState(second.robot.model, second._data, kept, mujoco.mjtState.mjSTATE_INTEGRATION)
    for applied in rng.uniform(-1.0, 1.0, (200, 1, 8)):
        first.step(applied)
        second.step(applied)
        np.testing.assert_array_equal(second.integration_state(), first.integration_state())


def test_the_components_are_where_they_say_they_are() -> None:
    robot = load_robot("ant")
    world = BareWorld()
    world.place(*random_start(np.random.default_rng(2)))
    for _ in range(5):
        world.step(np.full(8, 0.3))
    state, offset = world.integration, 0
    parts = {}
    for name, size in integration_components(robot):
        parts[name] = state[offset : offset + size]
        offset += size
    assert offset == mujoco.mj_stateSize(world.model, INTEGRATION)
    assert parts["time"] == [world.data.time]
    np.testing.assert_array_equal(parts["qpos"], world.data.qpos)
    np.testing.assert_array_equal(parts["qvel"], world.data.qvel)
    np.testing.assert_array_equal(parts["ctrl"], world.data.ctrl)
    np.testing.assert_array_equal(parts["warmstart"], world.data.qacc_warmstart)
