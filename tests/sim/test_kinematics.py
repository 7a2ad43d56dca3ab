from __future__ import annotations

import mujoco
import numpy as np

from tests.sim.bare import BareWorld, random_start
from waypointctl.robots.load import load_robot
from waypointctl.sim.geometry import WORLD
from waypointctl.sim.kinematics import RobotKinematics


def test_the_bodies_are_where_mujoco_has_them() -> None:
    kinematics, world = RobotKinematics(load_robot("ant")), BareWorld()
    rng = np.random.default_rng(0)
    for _ in range(20):
        qpos, qvel = random_start(rng)
        world.place(qpos, qvel)
        mujoco.mj_forward(world.model, world.data)
        positions, quaternions = kinematics.poses(qpos)
        for i, name in enumerate(kinematics.body_names):
            np.testing.assert_array_equal(positions[i], world.data.body(name).xpos)
            np.testing.assert_array_equal(quaternions[i], world.data.body(name).xquat)


def test_the_shapes_put_together_again_are_the_robot() -> None:
    kinematics, model = RobotKinematics(load_robot("ant")), BareWorld().model
    assert len(kinematics.geoms) == model.ngeom == 15
    assert {geom.body for geom in kinematics.geoms} <= {WORLD, *kinematics.body_names}
    foot = next(geom for geom in kinematics.geoms if geom.body == "front_left_shin")
    assert foot.kind == "capsule"
    np.testing.assert_allclose(foot.position, [0.2, 0.2, 0.0])
    np.testing.assert_allclose(foot.size[:2], [0.08, np.hypot(0.4, 0.4) / 2])
