"""Where a robot's folder is. Nothing is compiled for it, and no simulator loaded."""

from __future__ import annotations

import difflib
import os
from pathlib import Path
from typing import Final

from waypointctl.errors import RobotError
from waypointctl.mission.policy_name import is_bare
from waypointctl.mission.yaml_source import read_model, read_source
from waypointctl.paths import folder_fault
from waypointctl.robots.description import ROBOT_FILE, RobotDescription

SHIPPED: Final = Path(__file__).resolve().parent


def robot_names() -> tuple[str, ...]:
    """Return the names of the robots that come with waypointctl."""
    return tuple(sorted(path.parent.name for path in SHIPPED.glob(f"*/{ROBOT_FILE}")))


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
