"""Problems of a mission's robot and policy: what a flight would refuse before it begins."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from waypointctl.errors import InputError
from waypointctl.mission.files import MissionFile
from waypointctl.mission.policy_name import is_bare, policies_there_are
from waypointctl.mission.problems import Problem
from waypointctl.mission.yaml_tree import read_tree
from waypointctl.paths import folder_fault
from waypointctl.policy.bundle import load_policy, read_manifest
from waypointctl.policy.require import refuse_other_robot
from waypointctl.robots.folder import read_description


def robot_and_policy_problems(file: MissionFile, policy: Path) -> tuple[Problem, ...]:
    """Return why the robot or the policy cannot be loaded, or why they do not fit each other.

    A robot that comes with waypointctl is not compiled: that takes longer than all other checks of a mission, and its
    name alone shows whether the policy was made for it.

    Args:
        file: of the mission.
        policy: the folder of the policy that drives the robot.
    """
    named = file.mission.robot
    if folder_fault(policy):
        text = f"there is no folder {policy}. {policies_there_are(file.mission.policy)}"
        missing = (_problem(file, "policy", text),)
        return (*_problems(file, "robot", lambda: read_description(named)), *missing)
    if is_bare(named):
        return _problems(file, "robot", lambda: read_description(named)) or _problems(
            file, "policy", lambda: refuse_other_robot(read_manifest(policy), read_description(named).name)
        )
    # The simulator takes 0.3 s to load, which a mission with a robot that comes with waypointctl need not wait for.
    from waypointctl.flight.policy_fit import refuse_misfit
    from waypointctl.robots.load import load_robot

    return _problems(file, "robot", lambda: load_robot(named)) or _problems(
        file, "policy", lambda: refuse_misfit(load_policy(policy), load_robot(named))
    )


def _problems(file: MissionFile, key: str, check: Callable[[], Any]) -> tuple[Problem, ...]:
    """Return why a check refuses what the mission names under a key, each reason at that key."""
    try:
        check()
    except InputError as error:
        place, hint = f"{error.where}: " if error.where else "", f"; {error.hint}" if error.hint else ""
        return tuple(_problem(file, key, text) for text in error.details or (f"{place}{error.problem}{hint}",))
    return ()


def _problem(file: MissionFile, key: str, text: str) -> Problem:
    tree = read_tree(file.source)
    mark = tree.values.get((key,)) or tree.values[()]
    return Problem(str(file.path), mark.line, mark.column, key, text)
