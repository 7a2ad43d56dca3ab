"""What may go wrong with the schedule: commands that come too late, or that the robot cannot obey."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.mission.mission import Mission
from waypointctl.mission.schedule import ScheduledCommand
from waypointctl.ops.executive.rules import rules_of
from waypointctl.ops.forecast.duration import Expected
from waypointctl.ops.forecast.finding import Finding
from waypointctl.ops.forecast.losses import loses_all
from waypointctl.ops.forecast.traffic import Traffic, scheduled_bytes
from waypointctl.units import ns, seconds

_ONE_AT_A_TIME: Final = "the robot has one waypoint at a time, and may walk to it"
_NO_PLAN: Final = "the robot has no plan of its own"

# Which commands have no effect under an autonomy, and why.
_WITHOUT_EFFECT: Final[dict[tuple[str, str], str]] = {
    ("waypoint", "release"): _ONE_AT_A_TIME,
    ("heading", "release"): _ONE_AT_A_TIME,
    ("joint", "release"): _NO_PLAN,
    ("joint", "skip"): _NO_PLAN,
    ("joint", "set_tolerance"): _NO_PLAN,
    ("joint", "set_timeout"): _NO_PLAN,
    ("joint", "abort"): "the pilot's next action takes the motors again; hold stops it",
}
_LASTING: Final = ("go_to", "return_home")  # the others are over as soon as they are obeyed


# Commands that end what the operator has asked for, where the robot walks by itself.
_ENDING: Final = ("go_to", "return_home", "abort")
_SURELY: Final = 0.8  # of the time that is expected: so early a plan is not at its end


def schedule_findings(mission: Mission, traffic: Traffic, own: Expected) -> Iterator[Finding]:
    """Yield the scheduled commands that the robot will not obey, or that the mission fails by.

    Args:
        mission: that has the schedule.
        traffic: its link.
        own: what is expected of the mission without the schedule.
    """
    fence = rules_of(mission).fence
    for place, command in enumerate(mission.schedule):
        path = ("schedule", place)
        if command.position_m is not None and (breach := fence.breach(*command.position_m)):
            x_m, y_m = command.position_m
            yield Finding("fence", (*path, "position_m"), f"({x_m:g}, {y_m:g}) {breach}: the robot will reject it")
            continue
        arrives_ns = traffic.arrives_up_ns(ns(command.at_s), scheduled_bytes(command, mission))
        arrives_s = None if arrives_ns is None else seconds(arrives_ns)
        found = _never_sent(mission, command) or _too_late(mission, command, arrives_s) or _idle(mission, command)
        found = found or _ends_it(mission, command, arrives_s, own)
        if found is not None:
            field, text = found
            yield Finding("schedule", (*path, field), text)
    yield from _over_already(mission)


def _never_sent(mission: Mission, command: ScheduledCommand) -> tuple[str, str] | None:
    limit_s = mission.expect.max_time_s
    if limit_s is None or command.at_s <= limit_s:
        return None
    return "at_s", f"{command.do} is never sent: the flight ends at {limit_s:g} s, its expect.max_time"


def _too_late(mission: Mission, command: ScheduledCommand, arrives_s: float | None) -> tuple[str, str] | None:
    if arrives_s is None:
        if loses_all(mission.link.up.loss):
            return None  # the link says so itself
        return "at_s", f"{command.do} is never sent: no contact up has room for it from {command.at_s:g} s on"
    if command.expires_s is not None and command.expires_s < arrives_s:
        text = (
            f"{command.do} expires at {command.expires_s:g} s, and arrives at about {arrives_s:.2f} s: it is not obeyed"
        )
        return "expires_s", text
    obeyed_s = max(arrives_s, command.not_before_s or 0.0)
    limit_s = mission.expect.max_time_s
    if limit_s is not None and obeyed_s > limit_s:
        field, when = ("not_before_s", "is kept until") if obeyed_s > arrives_s else ("at_s", "arrives at about")
        return field, f"{command.do} {when} {obeyed_s:.2f} s, and the flight ends at {limit_s:g} s, its expect.max_time"
    return None


def _idle(mission: Mission, command: ScheduledCommand) -> tuple[str, str] | None:
    why = _WITHOUT_EFFECT.get((mission.autonomy, command.do))
    return None if why is None else ("do", f"{command.do} does nothing under autonomy {mission.autonomy}: {why}")


def _ends_it(
    mission: Mission, command: ScheduledCommand, arrives_s: float | None, own: Expected
) -> tuple[str, str] | None:
    """Return what makes a mission a failure: a command that takes its place while waypoints are left."""
    wants_all = mission.expect.reached in ("all", mission.num_legs)
    if mission.autonomy == "joint" or command.do not in _ENDING or not wants_all:
        return None
    if arrives_s is None or own.time_s is None or max(arrives_s, command.not_before_s or 0.0) > _SURELY * own.time_s:
        return None
    text = (
        f"{command.do} ends the plan before all waypoints are reached, which is expected after {own.time_s:.1f} s: the "
        "mission fails; to mean that, set expect.reached"
    )
    return "do", text


def _over_already(mission: Mission) -> Iterator[Finding]:
    """Yield what cancels a command that is over as soon as it is obeyed, where all numbers are known."""
    if mission.autonomy != "mission":
        return
    in_turn = sorted(mission.schedule, key=lambda command: command.at_s)
    for place, command in enumerate(mission.schedule):
        if command.command is None or command.command < 2:  # the first is the plan
            continue
        meant = in_turn[command.command - 2]
        if meant.do not in _LASTING and (meant.not_before_s or 0.0) <= command.at_s:
            text = f"command {command.command} is the {meant.do} of {meant.at_s:g} s, which is over once it is obeyed"
            yield Finding("schedule", ("schedule", place, "command"), text)
