"""What may go wrong with the schedule: commands that come too late, or that the robot cannot obey."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.flight.executive.rules import rules_of
from waypointctl.flight.forecast.effect import Effect
from waypointctl.flight.forecast.finding import Finding
from waypointctl.flight.forecast.losses import loses_all
from waypointctl.flight.forecast.traffic import Traffic, scheduled_bytes
from waypointctl.mission.mission import Mission
from waypointctl.mission.schedule import ScheduledCommand
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
# What ends the plan, or a part of it: somebody may mean that.
_ENDING: Final = ("go_to", "return_home", "abort", "cancel", "skip")


def schedule_findings(mission: Mission, traffic: Traffic, effect: Effect) -> Iterator[Finding]:
    """Yield the scheduled commands that the robot will not obey, or that the mission fails by.

    Args:
        mission: that has the schedule.
        traffic: its link.
        effect: what the schedule makes of the mission.
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
        if found is None and place == effect.culprit:
            found = _fails_by(mission, command, effect)
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


def _fails_by(mission: Mission, command: ScheduledCommand, effect: Effect) -> tuple[str, str]:
    """Return what becomes of a mission by one command of its schedule."""
    rehearsed = effect.rehearsed
    if rehearsed is None or (not rehearsed.ends and command.do == "hold"):
        return "do", "no command follows this hold: the mission never ends"
    count = mission.num_legs
    facts = f"{rehearsed.reached} of {count} waypoint{'s' * (count > 1)} reached"
    meant = "; if that is meant, set expect.reached" if command.do in _ENDING else ""
    if not rehearsed.ends:
        why = f"{rehearsed.reason}, and no command follows" if rehearsed.reason else "nothing more happens"
        return "do", f"the mission never ends after this {command.do}: {why}, {facts}{meant}"
    at = f"at about {rehearsed.time_s:.1f} s"
    return "do", f"the mission is expected to fail by this {command.do}, {at}: {rehearsed.reason}, {facts}{meant}"


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
