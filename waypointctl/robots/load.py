"""Finding and reading a robot's folder."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Final

from waypointctl.errors import InputError, RobotError
from waypointctl.input_file import NOT_THERE, read_input
from waypointctl.limits import limit
from waypointctl.mission.policy_name import is_bare
from waypointctl.mission.yaml_source import read_model, read_source
from waypointctl.paths import folder_fault
from waypointctl.robots.build import build_robot
from waypointctl.robots.description import ROBOT_FILE, RobotDescription
from waypointctl.robots.robot import Robot
from waypointctl.sim.mjcf_audit import ReadFile, audited_mjcf
from waypointctl.sim.model import compile_model

_SHIPPED: Final = Path(__file__).resolve().parent


def robot_names() -> tuple[str, ...]:
    """Return the names of the robots that come with waypointctl."""
    return tuple(sorted(path.parent.name for path in _SHIPPED.glob(f"*/{ROBOT_FILE}")))


def robot_folder(named: str, beside: Path = Path()) -> Path:
    """Return the folder of a robot.

    Args:
        named: the name of a robot that comes with waypointctl, or a path to a folder with robot.yaml.
        beside: the folder that a path is relative to.

    Raises:
        RobotError: there is no such robot.
    """
    if named in robot_names():
        return _SHIPPED / named
    folder = beside / named
    if fault := folder_fault(folder):
        if is_bare(named):
            fault = f"there is no robot {named!r}; there are {', '.join(robot_names())}, or give the path of a folder"
            raise RobotError(fault)
        raise RobotError(fault, where=str(folder), hint=f"a robot is a folder with {ROBOT_FILE}")
    return folder


def load_robot(named: str | Path, beside: Path = Path()) -> Robot:
    """Return a robot, compiled from its folder.

    Args:
        named: the name of a robot that comes with waypointctl, or a path to a folder with robot.yaml.
        beside: the folder that a path is relative to.

    Raises:
        RobotError: there is no such robot, or its robot.yaml is wrong; everything wrong has its line and column.
        InputError: its MJCF does not compile, names what is not read, or is no robot's.
    """
    folder = robot_folder(os.fspath(named), beside)
    return _shipped(folder) if folder.parent == _SHIPPED else _load(folder)


def robot_of_files(files: Mapping[str, bytes], where: str) -> Robot:
    """Return the robot whose folder has these files, by their paths in there; a log carries them.

    Args:
        files: robot.yaml, the MJCF and what it names.
        where: the folder, for messages.

    Raises:
        RobotError, InputError: as for `load_robot`.
    """

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
