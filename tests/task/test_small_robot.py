"""The task on a robot with three actuators, a passive joint and joints without a range."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.robots.folders import write_folder
from waypointctl.robots.load import load_robot
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import DomainRandomization, SensorNoise, TaskConfig
from waypointctl.task.observation import GROUPS, LAYOUTS, layout

JOINTS = ("left_wheel", "right_wheel", "boom", "steer")


@pytest.fixture(scope="module")
def cart(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_folder(tmp_path_factory.mktemp("robots") / "cart")


def test_names_and_sizes_are_those_of_the_robot(cart: Path) -> None:
    robot = load_robot(cart)
    names = [
        name for name, _, _ in layout(("joint_angles", "joint_speeds", "last_action", "contacts"), robot).components
    ]
    assert names[:4] == [f"{joint}.angle" for joint in JOINTS]
    assert names[4:8] == [f"{joint}.speed" for joint in JOINTS]
    assert names[8:11] == ["right_wheel.action", "left_wheel.action", "steer.action"]
    assert names[11:] == ["left_tyre.contact", "right_tyre.contact", "runner.contact"]
    assert [name for name, _, _ in layout(("position",), robot).components] == ["hull.x", "hull.y", "hull.z"]
    assert {name: layout(name, robot).size for name in LAYOUTS} == {
        "state": 17,
        "state_noise": 21,
        "state_goal": 21,
        "egocentric": 23,
    }


def test_it_steps_with_every_group_and_every_term(cart: Path) -> None:
    varied = DomainRandomization(latency_s=(0.0, 0.04), sensor_noise=SensorNoise(joint_angle_rad=0.01))
    groups = tuple(group.name for group in GROUPS)
    env = BatchedWaypointEnv(
        TaskConfig(robot=str(cart), observation=groups, domain_randomization=varied), 2, seed=1, threads=1
    )
    env.reset()
    for actions in np.random.default_rng(0).uniform(-1, 1, (20, 2, 3)):
        step = env.step(actions)
    assert step.observation.shape == (2, env.layout.size)
    assert np.isfinite(step.observation).all()
    assert np.isfinite(step.terms).all()
    limits = step.terms[:, env.reward.names.index("joint_limits")]
    assert (limits == 0).all()  # two joints have no range, two are within theirs
