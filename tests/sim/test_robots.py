from __future__ import annotations

import re

import mujoco
import numpy as np
import pytest

from tests.sim.bare import BareWorld, random_start
from waypointctl.errors import InputError
from waypointctl.sim.robots import compile_mjb, load_robot, robot_from_source

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


def test_the_mjb_loads_back_as_the_very_model() -> None:
    robot = load_robot("ant")
    mjb = robot.to_mjb()
    back = robot_from_source("ant", robot.mjcf.encode(), mjb, "model.xml")
    assert back.to_mjb() == mjb
    assert back.joint_names == robot.joint_names
    assert back.control_period_ns == robot.control_period_ns
    rng = np.random.default_rng(0)
    worlds = BareWorld(), BareWorld(back.model)
    start = random_start(rng)
    for world in worlds:
        world.place(*start)
    for applied in rng.uniform(-1.0, 1.0, (200, 8)):
        for world in worlds:
            world.step(applied)
        np.testing.assert_array_equal(worlds[0].integration, worlds[1].integration)


def test_the_source_compiles_to_the_same_bytes_every_time() -> None:
    robot = load_robot("ant")
    source = robot.mjcf.encode()
    assert compile_mjb(source, "model.xml") == compile_mjb(source, "model.xml") == robot.to_mjb()


def test_an_unknown_robot_is_refused_with_those_there_are() -> None:
    with pytest.raises(InputError, match="there is no robot called 'rover'; there are: ant"):
        load_robot("rover")
    with pytest.raises(InputError, match="there is no robot called 'rover'; there are: ant"):
        robot_from_source("rover", b"", b"", "model.xml")


def changed(before: str, after: str) -> bytes:
    source = load_robot("ant").mjcf
    assert before in source
    return source.replace(before, after).encode()


def carried(source: bytes) -> None:
    robot_from_source("ant", source, compile_mjb(source, "model.xml"), "model.xml")


def test_a_compiled_model_that_is_not_its_sources_is_refused() -> None:
    robot = load_robot("ant")
    for mjb in (b"", robot.to_mjb()[:1000], robot.to_mjb()[:-1] + b"\xff"):
        with pytest.raises(
            InputError, match=r"model\.xml: does not compile to the compiled model beside it in MuJoCo 3"
        ):
            robot_from_source("ant", robot.mjcf.encode(), mjb, "model.xml")


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (changed("</mujoco>", ""), "is not XML: no element found"),
        (
            changed('type="sphere"', 'type="cube"'),
            f"does not compile in MuJoCo {mujoco.__version__}: XML Error: invalid",
        ),
        (changed('timestep="0.01"', 'timestep="0"'), "is not a model of the ant: its time step is 0 s, not from 1e-05"),
        (changed('timestep="0.01"', 'timestep="-0.01"'), "its time step is -0.01 s"),
        (changed('timestep="0.01"', 'timestep="1e9"'), r"its time step is 1e\+09 s"),
        (re.sub(r"<motor n.*/>", "", load_robot("ant").mjcf).encode(), "it has 0 motors, not 8"),
        (changed("<actuator>", '<actuator><motor joint="root"/>'), "it has 9 motors, not 8"),
        (changed('<freejoint name="root"/>', ""), "it is not a floating base with 8 hinge joints"),
        (changed('axis="0 0 1" range', 'type="slide" axis="0 0 1" range'), "it is not a floating base with 8 hinge"),
        (
            changed('name="front_left_hip" joint="front_left_hip"', 'joint="front_left_ankle"'),
            "each motor turns one joint",
        ),
        (b'<mujoco model="ant"/>', "it has 0 motors, not 8"),
    ],
)
def test_a_model_that_is_not_the_robots_is_refused(source: bytes, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        carried(source)
    assert str(caught.value.where).startswith("model.xml")
