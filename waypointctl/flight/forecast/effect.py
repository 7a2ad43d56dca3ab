"""What a schedule, a fence and the rules on board make of a mission, gone through on paper.

What is expected without them is worked out elsewhere; here it gets longer by as much as they make the mission longer on
paper, and by what goes on after the operator knows the end: a way home, a hold that ends by itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

from waypointctl.flight.executive.rules import rules_of
from waypointctl.flight.forecast.budget import Budget
from waypointctl.flight.forecast.duration import Autonomy, Expected
from waypointctl.flight.forecast.rehearsal import Rehearsed, rehearse
from waypointctl.mission.mission import Mission
from waypointctl.mission.onboard import Geofence
from waypointctl.mission.schedule import ScheduledCommand

_MOST_REHEARSALS: Final = 20  # in search of the command that a mission fails by


@dataclass(frozen=True, slots=True)
class Effect:
    """What becomes of a mission on paper.

    Attributes:
        expected: of the mission with its schedule, its fence and its rules.
        counted: whether the schedule is in it.
        culprit: the place in the schedule of the command that the mission fails by; None where none is to blame.
        rehearsed: how it goes with the whole schedule, where that is known.
    """

    expected: Expected
    counted: bool = True
    culprit: int | None = None
    rehearsed: Rehearsed | None = None


def effect_of(mission: Mission, speed_mps: float, without: Expected, budget: Budget, doubt: str = "") -> Effect:
    """Return what the schedule, the fence and the rules on board make of a mission.

    Args:
        mission: with its schedule.
        speed_mps: how fast the policy walks.
        without: what is expected of it without them, under the autonomy that is asked about.
        budget: of what is rehearsed; where it is spent the schedule is not counted.
        doubt: by what the mission may fail, in words; it is taken to fail by that where it cannot be rehearsed.
    """
    if without.blocked is not None or without.falls:
        return Effect(without)
    asked, about_s = _under(mission, without.autonomy), (without.time_s or 0.0) + _way_home_s(mission, speed_mps)
    plain = _without_rules(_with(asked, ()))
    after = rehearse(asked, speed_mps, about_s, budget)
    before = after if plain == asked else rehearse(plain, speed_mps, about_s, budget)
    if (held := _held_pilot(mission, without)) is not None:
        return Effect(_failing(without, f"nothing after the hold of schedule[{held}] resumes it"), culprit=held)
    if before is None or after is None:
        return Effect(_failing(without, doubt) if doubt else without, counted=not mission.schedule)
    if after.good:
        time_s = after.over_s
        if without.time_s is not None and before.good and before.reached == mission.num_legs:
            time_s += without.time_s - before.time_s  # the formula holds where every leg is walked to its end
        return Effect(replace(without, time_s=time_s), rehearsed=after)
    blamed = bool(mission.schedule) and without.autonomy == mission.autonomy
    culprit = _culprit(mission, asked, speed_mps, about_s, budget) if blamed else None
    return Effect(_failing(without, _why(mission, after)), culprit=culprit, rehearsed=after)


def goes_home(mission: Mission) -> bool:
    """Tell whether a rule or a scheduled command may send the robot home."""
    rules = rules_of(mission)
    by_rule = "return_home" in (rules.then, rules.on_breach, rules.on_link_loss if rules.link_loss_ns > 0 else "")
    return by_rule or any(command.do == "return_home" for command in mission.schedule)


def _way_home_s(mission: Mission, speed_mps: float) -> float:
    """Return how long the way home takes from the farthest waypoint [s]; 0 where nothing sends the robot home."""
    if not goes_home(mission):
        return 0.0
    home = rules_of(mission).home
    return max(math.dist((leg.x_m, leg.y_m), (home.x_m, home.y_m)) for leg in mission.legs()) / speed_mps


def _failing(without: Expected, why: str) -> Expected:
    return replace(without, time_s=None, fails=why)


def _why(mission: Mission, rehearsed: Rehearsed) -> str:
    """Return why a mission failed on paper."""
    facts = f"{rehearsed.reached} of {mission.num_legs} waypoints reached"
    if not rehearsed.ends:
        return f"{rehearsed.reason or 'nothing more happens'}, {facts}"
    return f"{rehearsed.reason} at about {rehearsed.time_s:.1f} s, {facts}"


def _held_pilot(mission: Mission, without: Expected) -> int | None:
    """Return the place of a hold that no resume follows, under autonomy joint: a pilot waits for nothing else."""
    if without.autonomy != "joint" or without.time_s is None:
        return None
    told = [(command.at_s, place) for place, command in enumerate(mission.schedule) if command.do in ("hold", "resume")]
    at_s, last = max(told, default=(0.0, -1))
    is_hold = last >= 0 and mission.schedule[last].do == "hold" and mission.schedule[last].expires_s is None
    return last if is_hold and at_s < without.time_s else None


def _culprit(mission: Mission, asked: Mission, speed_mps: float, about_s: float, budget: Budget) -> int | None:
    """Return the place of the first scheduled command after which nothing makes the mission good again."""
    in_turn = sorted(asked.schedule, key=lambda command: command.at_s)
    for count in range(len(in_turn) - 1, max(len(in_turn) - 1 - _MOST_REHEARSALS, -1), -1):
        rehearsed = rehearse(_with(asked, tuple(in_turn[:count])), speed_mps, about_s, budget)
        if rehearsed is not None and rehearsed.good:
            return next(place for place, each in enumerate(mission.schedule) if each is in_turn[count])
    return None


def _under(mission: Mission, autonomy: Autonomy) -> Mission:
    """Return a mission under an autonomy, with all the time it needs; what is never sent for want of it is left out."""
    limit_s = mission.expect.max_time_s
    sent = tuple(each for each in mission.schedule if limit_s is None or each.at_s <= limit_s)
    expect = mission.expect.model_copy(update={"max_time_s": None})
    return mission.model_copy(update={"autonomy": autonomy, "expect": expect, "schedule": sent})


def _without_rules(mission: Mission) -> Mission:
    """Return a mission whose robot has no fence and no rule for a lost link or for getting no closer."""
    rules = {"geofence": Geofence(), "link_loss": None, "stuck": None}
    return mission.model_copy(update={"onboard": mission.onboard.model_copy(update=rules)})


def _with(mission: Mission, schedule: tuple[ScheduledCommand, ...]) -> Mission:
    return mission.model_copy(update={"schedule": schedule})
