"""Robots' folders to test with: a small robot of two motors and a passive joint, and the ant with something changed."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from pathlib import Path

from waypointctl.errors import RobotError
from waypointctl.robots.load import load_robot, robot_of_files
from waypointctl.robots.robot import Robot
from waypointctl.sim.mjcf_audit import AuditedMjcf, audited_mjcf

CART_XML = """\
<mujoco model="cart">
  <compiler angle="degree" autolimits="true"/>
  <option timestep="0.005" integrator="implicitfast"/>
  <worldbody>
    <geom name="ground" type="plane" size="0 0 1"/>
    <body name="hull" pos="0 0 0.3">
      <freejoint/>
      <geom name="hull" type="box" size="0.3 0.2 0.05" mass="5"/>
      <body name="left" pos="0.2 0.2 -0.1">
        <joint name="left_wheel" axis="0 1 0" damping="0.01"/>
        <geom name="left_tyre" type="cylinder" size="0.15 0.03" euler="90 0 0" mass="1"/>
      </body>
      <body name="right" pos="0.2 -0.2 -0.1">
        <joint name="right_wheel" axis="0 1 0" damping="0.01"/>
        <geom name="right_tyre" type="cylinder" size="0.15 0.03" euler="90 0 0" mass="1"/>
      </body>
      <body name="rear" pos="-0.2 0 0">
        <joint name="boom" axis="0 0 1" range="-60 60" damping="0.5" stiffness="5"/>
        <geom name="boom" type="capsule" fromto="0 0 0 -0.1 0 -0.1" size="0.02" mass="0.2"/>
        <body name="caster" pos="-0.1 0 -0.15">
          <joint name="steer" axis="0 0 1" range="-45 45" damping="0.5" armature="0.01"/>
          <geom name="runner" type="ellipsoid" size="0.1 0.1 0.1" mass="0.5" friction="0.1"/>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <velocity joint="right_wheel" kv="2" ctrlrange="-20 20"/>
    <velocity joint="left_wheel" kv="2" ctrlrange="-20 20"/>
    <position joint="steer" kp="20" dampratio="1"/>
  </actuator>
</mujoco>
"""

CART_YAML = """\
name: cart
mjcf: cart.xml
substeps: 4
actions:
  - {kind: velocity_target, joints: ["*_wheel"], scale_radps: 10, offset_radps: 2, limits_radps: [-9, 9]}
  - {kind: position_target, joints: [steer], scale: 30 deg, limits: [-20 deg, 20 deg]}
nominal: {height: 0.25 m, joints_deg: {steer: 10}}
termination: {min_height: 0.1 m, min_up: 0.3}
feet: [left_tyre, right_tyre, runner]
camera: {position: [0 m, 0 m, 0.5 m], pitch: -20 deg}
"""

STEER = "kind: position_target, joints: [steer], scale: 30 deg, limits: [-20 deg, 20 deg]"
CART = {"robot.yaml": CART_YAML.encode(), "cart.xml": CART_XML.encode()}


def write_folder(folder: Path, files: Mapping[str, bytes] = CART) -> Path:
    """Write a robot's folder; return it."""
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    return folder


def cart_with(**changes: tuple[str, str]) -> Robot:
    """Return the cart with a text replaced in robot.yaml (`yaml=(before, after)`) or in its MJCF (`xml=...`)."""
    files = dict(CART)
    for name, (before, after) in changes.items():
        path = {"yaml": "robot.yaml", "xml": "cart.xml"}[name]
        assert before.encode() in files[path]
        files[path] = files[path].replace(before.encode(), after.encode())
    return robot_of_files(files, "cart")


def reading(files: Mapping[str, bytes]) -> Callable[[str], bytes]:
    """Return what reads from `files` as the loader does from a folder."""

    def read(path: str) -> bytes:
        if path not in files:
            raise RobotError("there is no such file", where=path)
        return files[path]

    return read


def audited(source: bytes, **files: bytes) -> AuditedMjcf:
    return audited_mjcf("model.xml", reading({"model.xml": source, **files}))


def ant_of(mjcf: bytes) -> Robot:
    """Return the ant with another MJCF."""
    return robot_of_files({**load_robot("ant").files, "ant.xml": mjcf}, "robot")


def tetrahedron(size_m: float = 1.0) -> bytes:
    """Return a binary STL file."""
    corners = [(0.0, 0.0, 0.0), (size_m, 0.0, 0.0), (0.0, size_m, 0.0), (0.0, 0.0, size_m)]
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    packed = [struct.pack("<12fH", 0, 0, 0, *(c for at in face for c in corners[at]), 0) for face in faces]
    return b"\0" * 80 + struct.pack("<I", len(faces)) + b"".join(packed)
