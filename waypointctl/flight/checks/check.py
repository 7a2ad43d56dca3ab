"""All static checks of a mission, and of its robot and policy."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from waypointctl.display_text import shown
from waypointctl.errors import InputError
from waypointctl.flight.checks import Finding
from waypointctl.flight.checks.link import link_findings
from waypointctl.flight.checks.route import driving_time_s, route_findings, rule_findings
from waypointctl.flight.checks.schedule import ends_plan, schedule_findings, unused_findings
from waypointctl.flight.checks.traffic import Traffic
from waypointctl.flight.policy_fit import refuse_misfit
from waypointctl.mission.files import MissionFile
from waypointctl.mission.mission import Mission
from waypointctl.mission.policy_name import is_bare, policies_there_are
from waypointctl.mission.problems import Problem
from waypointctl.mission.yaml_tree import read_tree
from waypointctl.paths import folder_fault
from waypointctl.policy.manifest_file import read_manifest
from waypointctl.robots.load import read_description, shipped_outline
from waypointctl.task.plugins import load_plugins
from waypointctl.units import seconds


def check_mission(mission: Mission, speed_mps: float) -> tuple[Finding, ...]:
    """Return what may go wrong in a mission.

    Args:
        mission: with the files that it refers to.
        speed_mps: mean speed of the policy.

    Raises:
        MissionError: something is wrong with a file that the mission refers to.
    """
    traffic = Traffic(mission)
    least_s = _least_time_s(mission, speed_mps, traffic)
    findings = (
        *route_findings(mission, speed_mps),
        *rule_findings(mission, speed_mps),
        *schedule_findings(mission, traffic),
        *link_findings(mission, traffic, least_s),
        *_steering(mission, speed_mps, traffic),
        *unused_findings(mission),
        *_time_limit(mission, least_s),
        *_last_contact(mission, speed_mps, traffic),
    )
    return tuple(_once(findings))


def cannot_succeed(mission: Mission, findings: Iterable[Finding]) -> bool:
    """Tell whether a finding prevents what the mission expects: that every waypoint is reached."""
    expects_all = mission.expect.reached in ("all", mission.num_legs)
    return expects_all and any(finding.prevents for finding in findings)


def _least_time_s(mission: Mission, speed_mps: float, traffic: Traffic) -> float:
    """Return what a mission takes at least: T = L / v + N (RTT + think), with the round trip at mission start [s]."""
    exchanges = mission.num_legs if mission.autonomy in ("waypoint", "short_range_goal") else 1
    continuous = mission.autonomy == "short_range_goal" and mission.operator.steering == "continuous"
    exchanges = 1 if continuous else exchanges
    trip_s = seconds(traffic.round_trip_ns or 0)
    return driving_time_s(mission, speed_mps) + exchanges * trip_s + (exchanges - 1) * mission.operator.think_s


def _time_limit(mission: Mission, least_s: float) -> Iterator[Finding]:
    limit_s = mission.expect.max_time_s
    if limit_s is not None and least_s > limit_s and not ends_plan(mission):
        text = f"{limit_s:g} s is too short: the mission takes at least {least_s:.1f} s at the policy's mean speed"
        yield Finding("max_time", ("expect", "max_time_s"), text)


def _last_contact(mission: Mission, speed_mps: float, traffic: Traffic) -> Iterator[Finding]:
    """Yield contacts down of which the last ends before the robot can be at its last waypoint."""
    contacts, there_s = traffic.down.contacts, seconds(traffic.arrives_ns or 0) + driving_time_s(mission, speed_mps)
    last_s = seconds(contacts.windows[-1].end_ns)
    if not contacts.period_ns and last_s < there_s and not ends_plan(mission):
        field = "windows" if mission.link.down.contact_plan is None else "contact_plan"
        text = (
            f"the last contact down ends at {last_s:g} s; the robot is at its last waypoint at {there_s:.1f} s at the "
            "earliest, at the policy's mean speed, and cannot report that it is there"
        )
        yield Finding("contact", ("link", "down", field), text)


def _steering(mission: Mission, speed_mps: float, traffic: Traffic) -> Iterator[Finding]:
    """Yield short-range goals that the robot reaches before the next one arrives, under continuous steering."""
    script = mission.operator
    if mission.autonomy != "short_range_goal" or script.steering != "continuous" or traffic.round_trip_ns is None:
        return
    age_s = seconds(traffic.round_trip_ns) + script.think_s + 1 / script.update_rate_hz
    if speed_mps * age_s > script.lookahead_m:
        text = (
            f"a goal lies {script.lookahead_m:g} m ahead of a pose that is {age_s:.2f} s old, and the robot moves "
            f"{speed_mps * age_s:.1f} m in that time: it stops and waits between goals"
        )
        yield Finding("steering", ("operator", "lookahead_m"), text)


def _once(findings: Iterable[Finding]) -> Iterator[Finding]:
    """Yield of each kind of finding at a place of the file the first alone: rounds repeat them."""
    seen = set()
    for finding in findings:
        key = (finding.kind, finding.path)
        if key not in seen:
            seen.add(key)
            yield finding


def robot_and_policy_problems(file: MissionFile, policy: Path, plugins: Sequence[Path] = ()) -> tuple[Problem, ...]:
    """Return why the robot or the policy cannot be loaded, or why they do not fit each other.

    A robot that comes with waypointctl is not compiled, and the network of its policy not loaded: that takes longer
    than all other checks of a mission, and the manifest shows whether they fit.

    Args:
        file: of the mission.
        policy: the folder of the policy that drives the robot.
        plugins: Python files with groups of the policy, which are executed.

    Raises:
        InputError: a plugin is missing or fails.
    """
    named = file.mission.robot
    if fault := folder_fault(policy):
        given = file.mission.policy if policy == file.policy_path else str(policy)
        missing = _problem(file, "policy", f"{shown(given)}: {fault}. {policies_there_are(given)}")
        return (*_robot_problems(file, lambda: read_description(named)), missing)
    if is_bare(named) and not plugins:
        return _robot_problems(file, lambda: shipped_outline(named)) or _problems(
            file, "policy", lambda: refuse_misfit(read_manifest(policy), shipped_outline(named))
        )
    from waypointctl.policy.bundle import load_policy
    from waypointctl.robots.load import load_robot  # with the simulator, which takes 0.3 s to load

    executed = load_plugins(plugins)
    return _robot_problems(file, lambda: load_robot(named)) or _problems(
        file, "policy", lambda: refuse_misfit(load_policy(policy), load_robot(named), executed)
    )


def _robot_problems(file: MissionFile, check: Callable[[], Any]) -> tuple[Problem, ...]:
    """Return why a check refuses the mission's robot; its folder is quoted as the file has it."""
    named = file.mission.robot
    fault = None if is_bare(named) else folder_fault(Path(named))
    if fault is None:
        return _problems(file, "robot", check)
    written = read_tree(file.source).data.get("robot", named)
    text = f"{shown(written)}: {fault}; a robot is a folder with robot.yaml, relative to this file"
    return (_problem(file, "robot", text),)


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
