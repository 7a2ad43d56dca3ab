"""A flight with its log."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from waypointctl.errors import RobotError
from waypointctl.flight.camera import OnboardCamera
from waypointctl.flight.fly import fly
from waypointctl.flight.header import flight_header
from waypointctl.flight.operator.console import LineSource
from waypointctl.flight.operator.operator import planned_waypoints
from waypointctl.flight.outcome import FlightResult
from waypointctl.flight.sink import Sink, tee, with_pictures
from waypointctl.log.writer import LogWriter
from waypointctl.mission.files import MissionFile
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.require import require
from waypointctl.robots.load import load_robot
from waypointctl.robots.robot import Robot
from waypointctl.task.observation import layout


@dataclass(frozen=True, slots=True)
class Recording:
    """A flight that has been flown and logged.

    Attributes:
        result: how it ended.
        path: of the log.
        sha256: of the log's bytes.
        seed: of everything random in it.
        pictures: how many the log has.
        no_pictures: why there are none, and how to fix that, where there should be some.
    """

    result: FlightResult
    path: Path
    sha256: str
    seed: int
    pictures: int = 0
    no_pictures: str = ""


def record(
    mission_file: MissionFile,
    policy: LoadedPolicy,
    out: Path,
    *,
    watch: Sink | None = None,
    interrupted: Callable[[], bool] = lambda: False,
    console: LineSource | None = None,
    pictures: bool = False,
) -> Recording:
    """Fly a mission and write its log.

    Args:
        mission_file: the mission, and the text that goes into the log.
        policy: who walks.
        out: the log.
        watch: sees every message too, as it happens.
        interrupted: asked before every control step; True ends the flight and closes the log.
        console: where a person's commands come from, if there is a person.
        pictures: take one at each observation, where there is something that can draw.

    Raises:
        PolicyError: the policy was made for another robot or another observation layout.
        OutputError: the log cannot be written.
    """
    mission = mission_file.mission
    robot = robot_of(mission_file)
    refuse_misfit(policy, robot)
    with (
        OnboardCamera(robot, planned_waypoints(mission)) as camera,
        LogWriter(out, flight_header(mission_file, policy, robot)) as writer,
    ):
        sink = writer if watch is None else tee(writer, watch)
        if pictures:
            sink = with_pictures(sink, camera)
        result = fly(mission, policy, sink, robot=robot, interrupted=interrupted, console=console)
    return recording_of(result, out, mission.seed, camera.taken, camera.trouble)


def robot_of(mission_file: MissionFile) -> Robot:
    """Return the robot of a mission.

    Raises:
        RobotError, InputError: there is none, or it cannot be used.
    """
    try:
        return load_robot(mission_file.mission.robot)
    except RobotError as error:
        if error.where is not None:
            raise
        raise RobotError(f"robot: {error.problem}", where=mission_file.place("robot"), hint=error.hint) from error


def refuse_misfit(policy: LoadedPolicy, robot: Robot) -> None:
    """Refuse a policy that was not made for a robot.

    Raises:
        PolicyError: it was made for another robot, observation layout, control period or kind of action.
        InputError: there is no such observation layout.
    """
    require(
        policy,
        robot=robot.name,
        num_joints=robot.num_actions,
        components=layout(policy.observation_layout).components,
        control_period_ns=robot.control_period_ns,
    )


def recording_of(result: FlightResult, out: Path, seed: int, pictures: int = 0, no_pictures: str = "") -> Recording:
    """Return what is said of a flight whose log is closed; Recording says what the last two are."""
    with out.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    return Recording(result, out, digest, seed, pictures, no_pictures)
