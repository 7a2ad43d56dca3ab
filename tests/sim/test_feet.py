"""The height of the feet against MuJoCo's own kinematics and contacts."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from tests.sim.bare import random_start
from waypointctl.robots.load import load_robot
from waypointctl.sim.kinematics import Feet, feet_of


def test_a_foot_is_as_high_as_the_lowest_point_of_its_capsule_and_touches_where_mujoco_has_a_contact() -> None:
    robot, rng = load_robot("ant"), np.random.default_rng(0)
    feet, data = feet_of(robot, robot.feet), mujoco.MjData(robot.model)
    qpos = np.stack([random_start(rng)[0] for _ in range(200)])
    qpos[:, 2] = rng.uniform(0.3, 0.9, 200)
    heights = feet.heights(qpos)
    assert heights.shape == (200, 4)
    assert feet.names == ("front_left_foot", "back_left_foot", "back_right_foot", "front_right_foot")
    touching = 0
    for state, above in zip(qpos, heights, strict=True):
        data.qpos[:] = state
        mujoco.mj_forward(robot.model, data)
        touched = {robot.model.geom(geom).name for contact in data.contact for geom in contact.geom}
        for name, height, margin in zip(feet.names, above, feet.margins, strict=True):
            geom = robot.model.geom(name)
            ends = data.geom_xpos[geom.id, 2] + np.array([-1, 1]) * geom.size[1] * data.geom_xmat[geom.id, 8]
            assert height == pytest.approx(ends.min() - geom.size[0], abs=1e-9)
            assert (height < margin) == (geom.name in touched)
            touching += height < margin
    assert 100 < touching < 700


def test_a_box_is_as_low_as_its_lowest_corner_and_a_bent_model_pose_counts_from_there() -> None:
    mjcf = """<mujoco><worldbody><geom type="plane" size="9 9 1"/><body name="b"><freejoint/><geom size=".1"/>
      <body name="foot" pos="0 0 -.5"><joint name="j" axis="0 1 0" pos="0 0 .1" ref="30"/>
      <geom name="sole" type="box" size=".1 .2 .05" pos="0 0 -.2" euler="10 20 0"/></body></body></worldbody>
      <actuator><motor joint="j"/></actuator></mujoco>"""
    model = mujoco.MjModel.from_xml_string(mjcf)
    data, qpos = mujoco.MjData(model), np.array([[0, 0, 2.0, 0.9, 0.1, -0.3, 0.3, 0.4]])
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7])
    data.qpos[:] = qpos[0]
    mujoco.mj_forward(model, data)
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = data.geom_xpos[2] + (signs * model.geom_size[2]) @ data.geom_xmat[2].reshape(3, 3).T
    robot: Any = SimpleNamespace(model=model)
    assert Feet(robot, ("sole",)).heights(qpos)[0, 0] == pytest.approx(corners[:, 2].min(), abs=1e-9)
