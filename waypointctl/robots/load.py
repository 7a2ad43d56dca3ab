"""Finding and reading a robot's folder."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, lru_cache
from pathlib import Path

from waypointctl.errors import InputError, RobotError, wrong_type
from waypointctl.input_file import NOT_THERE, read_input
from waypointctl.limits import limit
from waypointctl.mission.yaml_source import read_model, read_source
from waypointctl.robots.build import build_robot
from waypointctl.robots.description import ROBOT_FILE, RobotDescription
from waypointctl.robots.folder import SHIPPED, robot_folder
from waypointctl.robots.robot import Robot
from waypointctl.sim.mjcf_audit import ReadFile, audited_mjcf
from waypointctl.sim.model import compile_model


def load_robot(named: str | Path) -> Robot:
    """Return a robot, compiled from its folder.

    Args:
        named: the name of a robot that comes with waypointctl, or the path of a folder with robot.yaml; a text without
            a slash is a name.

    Raises:
        RobotError: there is no such robot, or its robot.yaml is wrong; everything wrong has its line and column.
        InputError: its MJCF does not compile, names what is not read, or is not a robot's.
    """
    folder = robot_folder(named)
    return _shipped(folder) if folder.parent == SHIPPED else _load(folder)


def given_robot(robot: Robot | Path | str) -> Robot:
    """Return a robot that is given as itself, its folder, or its name.

    Raises:
        RobotError: as for `load_robot`.
        InputError: it is none of these, or as for `load_robot`.
    """
    if isinstance(robot, Robot):
        return robot
    if not isinstance(robot, Path | str):
        raise wrong_type("robot", robot, "a Robot, its folder, or its name")
    return load_robot(robot)


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
