"""Finding and reading a robot's folder. The simulator is loaded where a robot is compiled."""

from __future__ import annotations

import difflib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Final
from xml.etree import ElementTree

from waypointctl.errors import InputError, RobotError, given_path, wrong_type
from waypointctl.input_file import NOT_THERE, read_input
from waypointctl.limits import limit
from waypointctl.mission.policy_name import is_bare
from waypointctl.mission.yaml_source import read_model, read_source
from waypointctl.paths import folder_fault
from waypointctl.robots.description import ROBOT_FILE, RobotDescription
from waypointctl.units import NS_PER_S

if TYPE_CHECKING:
    from waypointctl.robots.robot import Robot
    from waypointctl.sim.mjcf_audit import ReadFile

SHIPPED: Final = Path(__file__).resolve().parent
ROBOT_COPY: Final = "robot"  # a user's robot, in the folder of a training run and of its policy


def robot_names() -> tuple[str, ...]:
    """Return the names of the robots that come with waypointctl."""
    return tuple(sorted(path.parent.name for path in SHIPPED.glob(f"*/{ROBOT_FILE}")))


@dataclass(frozen=True, slots=True)
class RobotOutline:
    """What a policy has to fit, with the names of `Robot`, known without a simulator."""

    name: str
    base: str
    joint_names: tuple[str, ...]
    actuated: tuple[int, ...]
    feet: tuple[str, ...]
    control_period_ns: int

    @property
    def num_actions(self) -> int:
        """How many actuators the robot has: the size of an action."""
        return len(self.actuated)


def shipped_outline(named: str) -> RobotOutline:
    """Return the outline of a robot that comes with waypointctl, whose MJCF has names and time step in plain sight.

    Raises:
        RobotError: there is no such robot.
    """
    description = read_description(named)
    mjcf = ElementTree.parse(SHIPPED / named / description.mjcf).getroot()
    step_s = float(next(mjcf.iterfind("option")).attrib["timestep"])
    joints = [each.attrib["name"] for each in mjcf.iterfind("worldbody//joint")]
    return RobotOutline(
        name=description.name,
        base=next(mjcf.iterfind("worldbody/body")).attrib["name"],
        joint_names=tuple(joints),
        actuated=tuple(joints.index(each.attrib["joint"]) for each in mjcf.iterfind("actuator/*")),
        feet=description.feet,
        control_period_ns=round(description.substeps * step_s * NS_PER_S),
    )


def kept_robot(folder: Path) -> Path | None:
    """Return the robot that a training has put into the folder of its run or its policy; None where there is none."""
    kept = folder / ROBOT_COPY
    return kept if os.path.isfile(kept / ROBOT_FILE) else None


def read_description(named: str | Path) -> RobotDescription:
    """Return the robot.yaml of a robot.

    Raises:
        RobotError: as for `robot_folder`, or it is wrong; everything wrong has its line and column.
    """
    folder = robot_folder(named)
    source = read_source(folder / ROBOT_FILE, RobotError, within=folder)
    return read_model(source, f"{folder}/{ROBOT_FILE}", RobotDescription, RobotError)


def robot_folder(named: str | Path) -> Path:
    """Return the folder of a robot.

    Args:
        named: the name of a robot that comes with waypointctl, or the path of a folder; a text without a slash is a
            name.

    Raises:
        RobotError: there is no such robot.
    """
    if isinstance(named, str) and is_bare(named):
        if named not in robot_names():
            near = difflib.get_close_matches(named, robot_names(), n=1)
            meant = f"; did you mean {near[0]!r}?" if near else ""
            hint = f"a folder with {ROBOT_FILE} is named with a slash: './{named}'"
            raise RobotError(f"there is no robot {named!r}; there are: {', '.join(robot_names())}{meant}", hint=hint)
        return SHIPPED / named
    folder = Path(named)
    if not os.path.isfile(folder / ROBOT_FILE):
        fault = folder_fault(folder) or f"has no {ROBOT_FILE}"
        raise RobotError(f"{os.fspath(named)}: {fault}", hint=f"a robot is a folder with {ROBOT_FILE}")
    return folder


def load_robot(named: str | Path) -> Robot:
    """Return a robot, compiled from its folder.

    Args:
        named: the name of a robot that comes with waypointctl, or the path of a folder with robot.yaml; a text without
            a slash is a name.

    Raises:
        RobotError: there is no such robot, or its robot.yaml is wrong; everything wrong has its line and column.
        InputError: its MJCF does not compile, names what is not read, or is not a robot's; or the argument is neither a
            name nor a path.
    """
    given_path("named", named, "a robot's folder, or its name")
    folder = robot_folder(named)
    return _shipped(folder) if folder.parent == SHIPPED else _load(folder)


def given_robot(robot: Robot | Path | str) -> Robot:
    """Return a robot that is given as itself, its folder, or its name.

    Raises:
        RobotError: as for `load_robot`.
        InputError: it is none of these, or as for `load_robot`.
    """
    if isinstance(robot, Path | str):
        return load_robot(robot)

    from waypointctl.robots.robot import Robot

    if not isinstance(robot, Robot):
        raise wrong_type("robot", robot, "a Robot, its folder, or its name")
    return robot


def robot_of_files(files: Mapping[str, bytes], where: str) -> Robot:
    """Return the robot whose folder has these files, by their paths in there; a log carries them.

    Args:
        files: robot.yaml, the MJCF and what it names.
        where: the folder, for messages.

    Raises:
        RobotError, InputError: as for `load_robot`.
    """
    return _of_files(tuple(sorted(files.items())), where)


@lru_cache(maxsize=4)  # a replay asks for it twice
def _of_files(items: tuple[tuple[str, bytes], ...], where: str) -> Robot:
    files = dict(items)

    def read(path: str) -> bytes:
        if path not in files:
            raise RobotError(NOT_THERE, where=f"{where}/{path}")
        return files[path]

    return _robot(read(ROBOT_FILE), read, where)


@cache
def _shipped(folder: Path) -> Robot:
    return _load(folder)


def _load(folder: Path) -> Robot:
    def read(path: str) -> bytes:
        return read_input(folder / path, limit("robot-files"), RobotError, within=folder)

    return _robot(read_source(folder / ROBOT_FILE, RobotError, within=folder), read, str(folder))


def _robot(source: bytes, read: ReadFile, where: str) -> Robot:
    from waypointctl.robots.build import build_robot
    from waypointctl.sim.mjcf_audit import audited_mjcf
    from waypointctl.sim.model import compile_model

    place = f"{where}/{ROBOT_FILE}"
    description = read_model(source, place, RobotDescription, RobotError)
    try:
        mjcf = audited_mjcf(description.mjcf, read, f"{where}/")
    except InputError as error:
        if error.problem == NOT_THERE:
            raise RobotError(f"mjcf: {error.where}: {error.problem}", where=place) from error
        raise
    model = compile_model(mjcf, f"{where}/{description.mjcf}")
    return build_robot(description, source, mjcf, model, place)
