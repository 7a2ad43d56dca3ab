from __future__ import annotations

import os
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tests.robots.folders import CART, CART_XML, STEER, ant_of, cart_with, tetrahedron, write_folder
from waypointctl.errors import InputError, RobotError
from waypointctl.robots.load import load_robot, robot_names, robot_of_files

ANT = load_robot("ant").files["ant.xml"].decode()


def changed(before: str, after: str) -> bytes:
    assert before in ANT
    return ANT.replace(before, after).encode()


def test_a_folder_is_a_robot(tmp_path: Path) -> None:
    robot = load_robot(str(write_folder(tmp_path / "cart")))
    assert (robot.name, robot.base, robot.num_actions, robot.control_period_ns) == ("cart", "hull", 3, 20_000_000)
    assert robot.joint_names == ("left_wheel", "right_wheel", "boom", "steer")
    np.testing.assert_array_equal(robot.actuated, [1, 0, 3])
    np.testing.assert_allclose(np.rad2deg(robot.joint_high), [np.inf, np.inf, 60, 45])
    np.testing.assert_allclose(np.rad2deg(robot.joint_low), [-np.inf, -np.inf, -60, -45])
    np.testing.assert_allclose(np.rad2deg(robot.nominal), [0, 0, 0, 10])
    assert robot.feet == ("left_tyre", "right_tyre", "runner")
    assert [each.name for each in robot.symmetries] == ["identity"]
    assert load_robot(tmp_path / "cart").to_mjb() == robot.to_mjb()


def test_a_shipped_robot_is_compiled_once_and_listed() -> None:
    assert load_robot("ant") is load_robot("ant")
    assert robot_names() == ("ant",)


@pytest.mark.parametrize(
    ("named", "message"),
    [
        ("hexapod", "there is no robot 'hexapod'; there are: ant\n"),
        ("./hexapod", "./hexapod: folder not found"),
        ("./a_file", "./a_file: is a file, not a folder"),
        ("./empty", "./empty: has no robot.yaml"),
    ],
)
def test_a_robot_that_is_not_there_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: str, message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a_file").touch()
    (tmp_path / "empty").mkdir()
    with pytest.raises(RobotError, match=re.escape(message)):
        load_robot(named)


@pytest.mark.parametrize("kind", ["link", "pipe", "folder", "missing"])
def test_an_mjcf_that_is_no_file_of_the_folder_is_refused(tmp_path: Path, kind: str) -> None:
    folder = write_folder(tmp_path / "cart")
    path = folder / "cart.xml"
    path.unlink()
    (tmp_path / "elsewhere.xml").write_text(CART_XML)
    if kind == "link":
        path.symlink_to(tmp_path / "elsewhere.xml")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    expected = {
        "link": "leads out of",
        "pipe": "a named pipe",
        "folder": "a folder",
        "missing": "there is no such file",
    }
    with pytest.raises(RobotError, match=expected[kind]):
        load_robot(folder)


def test_a_robot_with_meshes_is_made_of_those_files_alone(tmp_path: Path) -> None:
    mesh = '<mesh name="hull" file="hull.stl"/>'
    xml = CART_XML.replace("<worldbody>", f"<asset>{mesh}</asset><worldbody>", 1)
    xml = xml.replace("<compiler ", '<compiler meshdir="assets" ')
    xml = xml.replace('name="hull" type="box" size="0.3 0.2 0.05"', 'name="hull" type="mesh" mesh="hull"')
    files = {**CART, "cart.xml": xml.encode(), "assets/hull.stl": tetrahedron(0.4), "notes.txt": b"not a part"}
    robot = load_robot(write_folder(tmp_path / "cart", files))
    assert set(robot.files) == {"robot.yaml", "cart.xml", "assets/hull.stl"}
    assert robot.model.nmesh == 1
    assert robot_of_files(robot.files, "log").to_mjb() == robot.to_mjb()


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (changed("</mujoco>", ""), "is not XML: no element found"),
        (changed('type="sphere"', 'type="cube"'), f"does not compile in MuJoCo {mujoco.__version__}: XML Error"),
        (changed('timestep="0.01"', 'timestep="0"'), "its time step is 0 s, not from 1e-05 to 0.1 s"),
        (changed('timestep="0.01"', 'timestep="1e9"'), "its time step is 1e+09 s"),
        (re.sub(r"<motor n.*/>", "", ANT).encode(), "it has no actuators"),
        (changed("<actuator>", '<actuator><motor joint="root"/>'), "each actuator drives a hinge joint"),
        (changed('<freejoint name="root"/>', ""), "its first joint is not the <freejoint> of a base"),
        (changed('axis="0 0 1" range', 'type="slide" axis="0 0 1" range'), "front_left_hip, back_left_hip"),
        (
            changed('="front_left_hip" joint="front_left_hip"', '="a" joint="front_left_ankle"'),
            "each joint has one act",
        ),
        (
            changed('<joint name="front_left_hip"', "<joint").replace(
                b'<motor name="front_left_hip" joint="front_left_hip"/>', b""
            ),
            "a joint has no name",
        ),
        (
            changed('<body name="torso" pos="0 0 0.75">', '<body name="table"/><body name="torso">'),
            "its first body is not",
        ),
        (b'<mujoco model="ant"/>', "its first joint is not"),
    ],
)
def test_an_mjcf_that_is_no_robots_is_refused(source: bytes, message: str) -> None:
    with pytest.raises(InputError, match=re.escape(message)) as caught:
        ant_of(source)
    assert str(caught.value.where).startswith("robot/ant.xml")


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("substeps: 4", "substeps: 0", "cart/robot.yaml:3:11: substeps: expected a whole number from 1 to"),
        ("min_height: 0.1 m", "min_height: 0.25 m", "robot.yaml:8:14: termination: min_height 0.25 m is not below"),
        ("kind: position_target", "kind: postion_target", "robot.yaml:6:12: actions[1].kind: expected one of "
         "'torque_fraction', 'position_target' or 'velocity_target'; got 'postion_target'; did you mean "
         "'position_target'?"),
        ("{kind: position_target, ", "{", "robot.yaml:6:5: actions[1]: required key 'kind' is missing"),
        ("mjcf: cart.xml", "mjcf: ../cart.xml", "robot.yaml:2:7: mjcf: '../cart.xml' is not a file of this folder"),
        ("mjcf: cart.xml", "mjcf: other.xml", "cart/robot.yaml: mjcf: cart/other.xml: there is no such file"),
        ("min_up: 0.3", "min_tilt: 0.3", "cart/robot.yaml:8:34: termination.min_tilt: unknown key"),
        ("min_height: 0.1 m", "min_height: 9 m", ":8:14: termination: min_height 9 m is not below nominal.height"),
        ("kind: position_target", "kind: servo", "actions[1].kind: expected one of 'torque_fraction'"),
        ("kind: position_target, ", "", "actions[1]: required key 'kind' is missing"),
        ("steer: 10", "stear: 10", ":7:40: nominal.joints_deg.stear: there is no joint 'stear'; there are: left"),
        ("steer: 10", "steer: 50", "the nominal angle of steer is 50 deg, outside its range of -45 to 45 deg"),
        ("[steer]", "[boom]", "robot.yaml:6:38: actions[1].joints[0]: no actuator drives 'boom'; those that"),
        ("[steer]", "['*']", "right_wheel belongs to actions[0] already"),
        ('["*_wheel"]', "[left_wheel]", "cart/robot.yaml:4:1: actions: no entry covers right_wheel"),
        ("{kind: position_target", "{kind: velocity_target", "required key 'scale_radps' is missing"),
        ("velocity_target", "torque_fraction", "unknown key"),
        (STEER, "kind: torque_fraction, joints: [steer]",
         "robot.yaml:6:6: actions[1].kind: torque_fraction needs a motor actuator; steer has a position"),
        ("[-9, 9]", "[9, -9]", "no target of right_wheel is within all limits"),
        ("offset_radps: 2", "offset_radps: 20", "no action within -1 to 1 holds right_wheel at rest: it would be -2"),
        ("runner]", "runnner]", "robot.yaml:9:31: feet[2]: there is no geom 'runnner'"),
    ],
)  # fmt: skip
def test_a_mistake_in_robot_yaml_has_its_line_and_column(before: str, after: str, message: str) -> None:
    with pytest.raises(RobotError) as caught:
        cart_with(yaml=(before, after))
    assert message in str(caught.value)


SWAP = "symmetries: {swap: {mirror: true, joints: {left_wheel: right_wheel, right_wheel: left_wheel, "


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (SWAP + "boom: boom, steer: -steer}}}", "steer and steer differ in range or nominal angle"),
        (SWAP + "boom: -boom}}}", "has no image for steer"),
        (SWAP + "boom: steer, steer: boom}}}", "boom and steer do not both have an actuator"),
        (SWAP + "boom: boom, steer: boom}}}", "two joints map to boom"),
        (SWAP + "boom: boom, steer: wheel}}}", "there is no joint 'wheel'"),
        ("symmetries: {turn: {turn_deg: 1, joints: {left_wheel: left_wheel, right_wheel: right_wheel, "
         "boom: boom, steer: steer}}}", "they combine to more than 48 symmetries"),
    ],
)  # fmt: skip
def test_a_symmetry_that_cannot_be_is_refused(text: str, message: str) -> None:
    with pytest.raises(RobotError, match=re.escape(message)):
        cart_with(yaml=("feet:", f"{text}\nfeet:"))
