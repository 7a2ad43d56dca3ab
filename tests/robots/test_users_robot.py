"""A robot of a user's own, from its folder to the proof of its log: other names, servos in place of motors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.conftest import observation_of
from tests.robots.folders import write_folder
from waypointctl.cli.app import app
from waypointctl.evaluation.evaluate import evaluate
from waypointctl.evaluation.suite import load_suite
from waypointctl.flight.fly import fly
from waypointctl.log.reader import open_log
from waypointctl.mission.files import load_mission
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.verify import Verdict, verify
from waypointctl.robots.load import load_robot
from waypointctl.robots.robot import Robot, stance_action
from waypointctl.sim.stepping import SingleRobot
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import TaskConfig

MISSION = """\
name: stroll
robot: ../robots/beetle
policy: ../policy
waypoints:
  - {position: [0 m, 0.2 m], tolerance: 10 m, hold: 200 ms}
  - {position: [90 m, 0 m], timeout: 1 s}
on_failure: skip
expect: {reached: 1}
"""


def beetle() -> dict[str, bytes]:
    """Return the ant's folder with other names, and position servos in place of its motors."""
    files = {name: content.decode() for name, content in load_robot("ant").files.items()}
    xml = files["ant.xml"]
    for before, after in (("front", "fore"), ("back", "aft"), ("torso", "shell"), ("hip", "coxa"), ("ankle", "tibia")):
        xml = xml.replace(before, after)
        files["robot.yaml"] = files["robot.yaml"].replace(before, after)
    servo = '<position kp="80" kv="20" forcerange="-80 80"/>'
    xml = xml.replace('<motor gear="80" ctrllimited="true" ctrlrange="-1 1"/>', servo).replace("<motor", "<position")
    yaml = files["robot.yaml"].replace("name: ant", "name: beetle").replace("mjcf: ant.xml", "mjcf: mjcf/beetle.xml")
    yaml = yaml.replace("{kind: torque_fraction}", "{kind: position_target, scale: 20 deg}")
    return {"robot.yaml": yaml.encode(), "mjcf/beetle.xml": xml.encode()}


@dataclass(frozen=True)
class Work:
    """Where a user keeps robot, policy and mission."""

    folder: Path
    robot: Robot
    policy: LoadedPolicy


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Work:
    folder: Path = tmp_path_factory.mktemp("work")
    robot = load_robot(write_folder(folder / "robots" / "beetle", beetle()))
    (folder / "missions").mkdir()
    (folder / "missions" / "stroll.yaml").write_text(MISSION)
    policy = make_policy(folder / "policy", seed=3, robot="beetle", observation=observation_of(robot))
    return Work(folder, robot, policy)


@pytest.fixture(scope="module")
def log(work: Work) -> Path:
    """The log of a flight, with the robot's folder gone."""
    robots = work.folder / "robots"
    path = work.folder / "log.mcap"
    fly(load_mission(work.folder / "missions" / "stroll.yaml"), work.policy, log=path)
    robots.rename(work.folder / "away")
    return path


def test_it_has_the_names_of_its_own_mjcf(work: Work) -> None:
    assert work.robot.base == "shell"
    assert work.robot.joint_names[:2] == ("fore_left_coxa", "fore_left_tibia")
    assert len(work.robot.symmetries) == 8


def test_it_stands_without_a_policy(work: Work) -> None:
    robot, single = work.robot, SingleRobot(work.robot)
    single.place(np.array([[0, 0, robot.nominal_height_m, 1, 0, 0, 0, *robot.nominal]]), np.zeros((1, 14)))
    for _ in range(150):
        single.step(stance_action(robot, single.qpos, single.qvel))
    assert single.qpos[0, 2] > robot.min_height_m
    assert np.abs(single.qvel).max() < 0.05
    np.testing.assert_allclose(single.qpos[0, 7:], robot.nominal, atol=0.1)


def test_many_walk_their_courses(work: Work) -> None:
    env = BatchedWaypointEnv(TaskConfig(robot=str(work.folder / "robots" / "beetle")), 3, seed=1, threads=1)
    env.reset()
    for actions in np.random.default_rng(0).uniform(-1, 1, (5, 3, 8)):
        step = env.step(actions)
    assert np.isfinite(step.observation).all()
    assert np.isfinite(step.terms).all()


def test_a_suite_tests_its_policy(work: Work) -> None:
    path = work.folder / "missions" / "suite.yaml"
    path.write_text("name: near\nrobot: ../robots/beetle\ncases: [{name: a, waypoints: [[0.1, 0]]}]\n")
    result = evaluate(work.policy, load_suite(str(path)), trials=2, threads=1)
    assert result.cases[0].successes == 2


def test_the_log_carries_its_files_and_proves_itself_without_its_folder(work: Work, log: Path) -> None:
    attachments = open_log(log).attachments
    assert {name for name in attachments if name.startswith("robot/")} == {"robot/robot.yaml", "robot/mjcf/beetle.xml"}
    found = verify(log)
    assert (found.verdict, found.reason) == (Verdict.EXACT, found.reason)
    assert found.steps > 50


def test_a_flight_goes_on_from_its_log_without_its_folder(work: Work, log: Path, tmp_path: Path) -> None:
    whole = log.read_bytes()
    part = tmp_path / "log.mcap.part"
    part.write_bytes(whole[: len(whole) * 9 // 10])
    assert CliRunner().invoke(app, ["run", "--resume", str(part)]).exit_code == 0
    assert (tmp_path / "log.mcap").read_bytes() == whole
