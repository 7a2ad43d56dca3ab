"""Where a robot's folder is. Nothing is compiled for it, and no simulator loaded."""

from __future__ import annotations

import difflib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

from waypointctl.errors import RobotError
from waypointctl.mission.policy_name import is_bare
from waypointctl.mission.yaml_source import read_model, read_source
from waypointctl.paths import folder_fault
from waypointctl.robots.description import ROBOT_FILE, RobotDescription
from waypointctl.units import NS_PER_S

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
