from __future__ import annotations

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.sim.bare import BareWorld, random_start
from waypointctl.robots.load import load_robot, robot_of_files

FloatArray = NDArray[np.float64]
LEGS = ("front_left", "back_left", "back_right", "front_right")


def capsule_m3(length_m: float, radius_m: float = 0.08) -> float:
    return float(np.pi * radius_m**2 * length_m + 4 / 3 * np.pi * radius_m**3)


def test_the_ant_has_roboschools_joint_ranges_and_friction() -> None:
    robot = load_robot("ant")
    assert robot.joint_names == tuple(f"{leg}_{joint}" for leg in LEGS for joint in ("hip", "ankle"))
    np.testing.assert_allclose(np.rad2deg(robot.joint_low), [-40.0, 30.0] * 4)
    np.testing.assert_allclose(np.rad2deg(robot.joint_high), [40.0, 100.0] * 4)
    assert set(robot.model.geom_friction[:, 0]) == {1.5}


def test_the_ant_is_as_light_as_in_gymnasium_and_has_motors_of_80_nm_at_50_hz() -> None:
    robot = load_robot("ant")
    stub, shin = capsule_m3(np.hypot(0.2, 0.2)), capsule_m3(np.hypot(0.4, 0.4))
    torso = 4 / 3 * np.pi * 0.25**3
    assert robot.model.body_mass.sum() == pytest.approx(5.0 * (torso + 8 * stub + 4 * shin))
    np.testing.assert_array_equal(robot.model.actuator_gear[:, 0], np.full(8, 80.0))
    np.testing.assert_array_equal(robot.model.actuator_ctrlrange, [[-1.0, 1.0]] * 8)
    assert robot.control_period_ns == 20_000_000
    assert robot.substeps * robot.physics_period_s == pytest.approx(0.02, abs=1e-15)
    assert robot.model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST


def test_each_motor_turns_the_joint_of_its_place_in_the_state() -> None:
    model = load_robot("ant").model
    joints = model.actuator_trnid[:, 0]
    np.testing.assert_array_equal(model.jnt_qposadr[joints], np.arange(7, 15))
    np.testing.assert_array_equal(model.jnt_dofadr[joints], np.arange(6, 14))


def test_a_positive_ankle_angle_puts_the_foot_down() -> None:
    world = BareWorld()
    world.data.qpos[2] = 5.0
    for leg in LEGS:
        heights = []
        for angle in (30.0, 100.0):
            world.data.joint(f"{leg}_ankle").qpos[0] = np.deg2rad(angle)
            mujoco.mj_kinematics(world.model, world.data)
            heights.append(world.data.geom(f"{leg}_foot").xpos[2])
        assert heights[1] < heights[0]


def test_the_robot_of_the_files_is_the_very_robot() -> None:
    robot = load_robot("ant")
    back = robot_of_files(robot.files, "log/robot")
    assert set(robot.files) == {"robot.yaml", "ant.xml"}
    assert back.to_mjb() == robot.to_mjb()
    assert (back.joint_names, back.control_period_ns) == (robot.joint_names, robot.control_period_ns)


def test_it_stands_on_hips_at_0_and_ankles_at_45_degrees() -> None:
    robot = load_robot("ant")
    np.testing.assert_array_equal(robot.nominal, np.deg2rad([0.0, 45.0] * 4))
    assert (robot.nominal_height_m, robot.min_height_m, robot.min_up) == (0.49, 0.26, 0.2)
    assert robot.feet == tuple(f"{leg}_foot" for leg in LEGS)


def test_an_action_is_the_control_to_the_last_bit() -> None:
    actions = np.array([[-1.0, -0.0, 0.0, 1e-300, 0.3, 1.0, -0.7, 0.999]])
    assert load_robot("ant").actions.control(actions) is actions


def test_it_has_the_eight_symmetries_of_a_square() -> None:
    found = load_robot("ant").symmetries
    assert [each.name for each in found[:3]] == ["identity", "rotate90", "mirror"]
    assert len({each.key for each in found}) == 8
    turned = found[1].of_joints(np.arange(8.0)[np.newaxis])[0]
    np.testing.assert_array_equal(turned, [6, 7, 0, 1, 2, 3, 4, 5])


@pytest.mark.parametrize("number", range(8))
def test_the_image_of_a_motion_is_the_motion_of_the_image(number: int) -> None:
    """MuJoCo is the oracle: a step from an image of a state ends in the image of where the step from the state ends."""
    symmetry, rng = load_robot("ant").symmetries[number], np.random.default_rng(number)
    world, image = BareWorld(), BareWorld()
    qpos, qvel = random_start(rng)
    qpos[:7] = 0.0, 0.0, 0.6, 1.0, 0.0, 0.0, 0.0  # heading along x: frames of base and world agree
    applied = rng.uniform(-1, 1, (1, 8))

    def mapped(state: FloatArray, offset: int) -> FloatArray:
        return np.asarray(symmetry.of_joints(state[np.newaxis, offset:])[0])

    world.place(qpos, qvel)
    velocity, rates = symmetry.of_vectors(qvel[np.newaxis, :3])[0], symmetry.of_rotations(qvel[np.newaxis, 3:6])[0]
    image.place(np.concatenate([qpos[:7], mapped(qpos, 7)]), np.concatenate([velocity, rates, mapped(qvel, 6)]))
    for _ in range(5):
        world.step(applied[0])
        image.step(symmetry.of_joints(applied)[0])
    np.testing.assert_allclose(image.data.qpos[7:], mapped(world.data.qpos, 7), atol=1e-7)
    expected = symmetry.of_vectors(world.data.qpos[np.newaxis, :3])[0]
    np.testing.assert_allclose(image.data.qpos[:3], expected, atol=1e-7)
