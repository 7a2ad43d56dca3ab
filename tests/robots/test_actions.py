from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tests.robots.folders import STEER, cart_with
from waypointctl.robots.robot import Robot, stance_action
from waypointctl.sim.stepping import RobotBatch, SingleRobot


@pytest.fixture(scope="module")
def cart() -> Robot:
    return cart_with()


def test_an_action_is_offset_and_scale_within_limits(cart: Robot) -> None:
    actions = np.array([[0.0, 0.5, 0.0], [1.0, -1.0, 1.0], [0.7, -0.2, -1.0]])
    expected = [[2.0, 7.0, 10.0], [9.0, -8.0, 20.0], [9.0, 0.0, -20.0]]  # the last in degrees
    found = cart.actions.control(actions)
    np.testing.assert_allclose(found * [1.0, 1.0, 180 / np.pi], expected, atol=1e-12)


def test_the_limits_of_a_servo_are_the_narrowest_that_are_given() -> None:
    wide = cart_with(yaml=("limits_radps: [-9, 9]", "limits_radps: [-99, 99]"))
    np.testing.assert_array_equal(wide.actions.high[:2], [20.0, 20.0])  # of the MJCF's ctrlrange
    joint = cart_with(yaml=(", limits: [-20 deg, 20 deg]", ""))
    np.testing.assert_allclose(np.rad2deg(joint.actions.low[2]), -45.0)


def test_a_torque_fraction_is_of_the_control_range_of_the_mjcf() -> None:
    motor = cart_with(
        xml=('<position joint="steer" kp="20" dampratio="1"/>', '<motor joint="steer" ctrlrange="-7 7"/>'),
        yaml=(STEER, "kind: torque_fraction, joints: [steer]"),
    )
    assert motor.actions.control(np.array([[0.0, 0.0, -0.5]]))[0, 2] == -3.5
    np.testing.assert_array_equal(motor.is_servo, [True, True, False])


def test_servos_rest_at_the_nominal_pose_and_wheels_at_speed_0(cart: Robot) -> None:
    single = SingleRobot(cart)
    qpos = np.array([[0, 0, cart.nominal_height_m, 1, 0, 0, 0, *cart.nominal]], float)
    single.place(qpos, np.zeros((1, 10)))
    for _ in range(100):
        single.step(stance_action(cart, single.qpos, single.qvel))
    np.testing.assert_allclose(
        cart.actions.control(stance_action(cart, single.qpos, single.qvel))[0, :2], 0, atol=1e-12
    )
    np.testing.assert_allclose(np.rad2deg(single.qpos[0, -1]), 10.0, atol=1.0)
    assert np.abs(single.qvel).max() < 0.1


def test_one_and_many_take_the_same_actions_as_mujoco_its_controls(cart: Robot) -> None:
    rng = np.random.default_rng(0)
    single, batch = SingleRobot(cart), RobotBatch(cart, 2, threads=1)
    data = mujoco.MjData(cart.model)
    qpos = np.array([0, 0, cart.nominal_height_m, 1, 0, 0, 0, *cart.nominal], float)
    single.place(qpos[np.newaxis], np.zeros((1, 10)))
    batch.place(np.arange(2), np.stack([qpos, qpos]), np.zeros((2, 10)))
    data.qpos[:] = qpos
    for actions in rng.uniform(-1, 1, (20, 1, 3)):
        single.step(actions)
        batch.step(np.repeat(actions, 2, axis=0))
        data.ctrl[:] = cart.actions.control(actions)[0]
        mujoco.mj_step(cart.model, data, 4)
        np.testing.assert_array_equal(single.qpos[0], data.qpos)
        np.testing.assert_array_equal(batch.qpos[1], data.qpos)
