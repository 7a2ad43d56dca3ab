from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.sim.bare import BareWorld
from tests.task.rotations import matrix_of, quaternion_of
from waypointctl.task.view import Body, body_of, fallen

ANGLE = st.floats(-3.1, 3.1)
PITCH = st.floats(-1.5, 1.5)


def body_with(roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0, height: float = 0.5) -> Body:
    qpos = np.array([[1.0, 2.0, height, *quaternion_of(roll, pitch, yaw), *np.arange(8.0)]])
    return body_of(qpos, np.arange(14.0)[np.newaxis])


@given(ANGLE, PITCH, ANGLE)
@settings(max_examples=200, deadline=None)
def test_roll_pitch_and_yaw_are_the_angles_that_turned_it(roll: float, pitch: float, yaw: float) -> None:
    body = body_with(roll, pitch, yaw)
    assert body.roll[0] == pytest.approx(roll, abs=1e-7)
    assert body.pitch[0] == pytest.approx(pitch, abs=1e-7)
    assert body.yaw[0] == pytest.approx(yaw, abs=1e-7)
    assert body.up[0] == pytest.approx(matrix_of(roll, pitch, yaw)[2, 2], abs=1e-12)


def test_straight_up_and_down_pitch_is_a_right_angle() -> None:
    for pitch in (math.pi / 2, -math.pi / 2):
        assert body_with(pitch=pitch).pitch[0] == pytest.approx(pitch, abs=1e-7)


def test_the_numbers_are_where_mujoco_keeps_them() -> None:
    world = BareWorld()
    rng = np.random.default_rng(0)
    qpos = np.array([1.0, 2.0, 3.0, *quaternion_of(0.3, -0.4, 2.0), *rng.uniform(-0.5, 0.5, 8)])
    qvel = rng.normal(size=14)
    world.place(qpos, qvel)
    mujoco.mj_forward(world.model, world.data)
    body = body_of(qpos[np.newaxis], qvel[np.newaxis])
    world_velocity = np.zeros(6)
    mujoco.mj_objectVelocity(world.model, world.data, mujoco.mjtObj.mjOBJ_XBODY, 1, world_velocity, 0)
    own_velocity = np.zeros(6)
    mujoco.mj_objectVelocity(world.model, world.data, mujoco.mjtObj.mjOBJ_XBODY, 1, own_velocity, 1)
    np.testing.assert_allclose(body.position[0], world.data.body("torso").xpos)
    np.testing.assert_allclose(body.velocity[0], world_velocity[3:])
    np.testing.assert_allclose(body.rates[0], own_velocity[:3])
    assert body.up[0] == pytest.approx(world.data.body("torso").xmat[8])
    for i, name in enumerate(("front_left", "back_left", "back_right", "front_right")):
        for j, joint in enumerate(("hip", "ankle")):
            assert body.joints[0, 2 * i + j] == world.data.joint(f"{name}_{joint}").qpos[0]
            assert body.joint_rates[0, 2 * i + j] == world.data.joint(f"{name}_{joint}").qvel[0]


@pytest.mark.parametrize(
    ("tilt_deg", "height", "fell"),
    [(0, 0.5, False), (0, 0.27, False), (0, 0.25, True), (78, 0.5, False), (79, 0.5, True), (180, 0.5, True)],
)
def test_falls_when_too_low_or_tipped_too_far(tilt_deg: float, height: float, fell: bool) -> None:
    # cos 78.46 deg = 0.2
    assert fallen(body_with(roll=math.radians(tilt_deg), height=height), 0.26, 0.2).tolist() == [fell]
    assert fallen(body_with(pitch=-math.radians(tilt_deg), height=height), 0.26, 0.2).tolist() == [fell]
