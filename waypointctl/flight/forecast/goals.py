"""The short-range goals of an operator who steers: how many a leg takes, and how long each.

The numbers here are measured: 128 flights of ant-waypoint on the routes (5, 0), (5, 5); (6, 3), (8, 9) and
(7, 12), (14, 14), with goals 1, 2 and 4 m ahead, round trips from 0 to 364 s and, steered at a rate, 0.2, 1 and 5
goals a second. Of move and wait they tell the time within 10 %, of steering at a rate within 15 %, on average of the
seeds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from waypointctl.flight.forecast.way import Walk, within_m
from waypointctl.mission.mission import Mission

NEAR_LOOKAHEAD: Final = 0.25  # of its distance: within this a short-range goal counts as reached
_COAST_M: Final = 0.05  # how much further the robot comes before it stands
_BLEND_M: Final = 0.2  # and before the next goal, where goals come at a rate: some are from poses on the way
_SPREAD: Final = (0.95, 1.0, 1.05)  # no step is as long as the other; the last of a leg may just be needed or not
_GOING_ON_S: Final = 0.1  # what a new goal costs a robot that walks
SETTING_OUT_S: Final = 0.35  # and one that stands
_STANDS_AFTER_S: Final = 0.25
_FIRST_STEPS_S: Final = (0.3, 0.5, 0.7)  # after so long the pose that is heard is another: the next goal is further on


def goals_of(walk: Walk, mission: Mission, *, at_rate: bool = False) -> float:
    """Return how many short-range goals a leg takes, the waypoint itself among them, on average."""
    lookahead_m, away_m = mission.operator.lookahead_m, walk.away_m
    if away_m <= lookahead_m:
        return 1.0
    towards = ((walk.waypoint.x_m - walk.start_m[0]) / away_m, (walk.waypoint.y_m - walk.start_m[1]) / away_m)
    goal = replace(walk.waypoint, tolerance_m=min(walk.waypoint.tolerance_m, lookahead_m * NEAR_LOOKAHEAD))
    step_m = lookahead_m - within_m(goal, towards) + _COAST_M + (_BLEND_M if at_rate else 0.0)
    counts = [math.ceil((away_m - lookahead_m) / (step_m * part)) for part in _SPREAD]
    return sum(counts) / len(counts) + 1


def whole(counts: Sequence[float]) -> list[int]:
    """Return counts as whole numbers that add up to what they do, each at least 1."""
    wholes: list[int] = []
    sum_ = 0.0
    for count in counts:
        sum_ += count
        wholes.append(max(round(sum_) - sum(wholes), 1))
    return wholes


def setting_out_s(waits_s: float) -> float:
    """Return what a goal costs beside its way, after the robot has waited for it [s]."""
    return _GOING_ON_S + (SETTING_OUT_S - _GOING_ON_S) * min(waits_s / _STANDS_AFTER_S, 1.0)


def period_s(round_trip_s: float, update_rate_hz: float) -> float:
    """Return how long it takes, steering at a rate, until a goal is answered by one from a pose nearer to it [s].

    Goals leave at whole periods: the first one after the pose has been heard, with the robot on its way.
    """
    each_s = 1 / update_rate_hz
    cycles = [math.floor((round_trip_s + after_s) / each_s) + 1 for after_s in _FIRST_STEPS_S]
    return sum(cycles) / len(cycles) * each_s
