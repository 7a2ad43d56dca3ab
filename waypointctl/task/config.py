"""The definition of a task, in one record."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from waypointctl.mission.fields import Acceptance, Start
from waypointctl.robots.robot import Robot
from waypointctl.task.course import Course, Deadline
from waypointctl.task.domain_randomization import DomainRandomization
from waypointctl.task.failure_replay import FailureReplay
from waypointctl.task.plugins import Plugin
from waypointctl.task.reward import RewardWeights

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class TaskConfig:
    """A waypoint task: the robot, its observation, its reward, its courses, and when a waypoint counts as reached."""

    robot: Robot | Path | str = "ant"  # itself, its folder, or its name
    observation: str | tuple[str, ...] = "egocentric"  # a layout, or the names of groups
    reward: RewardWeights = field(default_factory=RewardWeights)
    course: Course = field(default_factory=Course)
    failure_replay: FailureReplay = field(default_factory=FailureReplay)
    acceptance: Acceptance = field(default_factory=Acceptance)
    deadline: Deadline = field(default_factory=Deadline)
    start: Start = field(default_factory=Start)
    domain_randomization: DomainRandomization = field(default_factory=DomainRandomization)
    plugins: tuple[Plugin, ...] = ()  # that groups and reward terms may come from


def draw_start(start: Start, robot: Robot, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Return a physics state to begin in: qpos (nq,) and qvel (nv,)."""
    joints, speeds = len(robot.nominal), len(robot.nominal) + 6
    heading = rng.uniform(-math.pi, math.pi) if start.random_heading else math.radians(start.heading_deg)
    qpos = np.empty(7 + joints)
    qpos[:3] = (*start.position_m, robot.nominal_height_m)
    qpos[3:7] = (math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2))
    qpos[7:] = robot.nominal + rng.uniform(-start.joint_spread_rad, start.joint_spread_rad, joints)
    return qpos, rng.uniform(-start.speed_spread, start.speed_spread, speeds)
