"""Who decides what: the ways of commanding that a study compares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

from waypointctl.errors import InputError

Level: TypeAlias = Literal["mission", "waypoint", "short_range_goal", "joint"]
Steering: TypeAlias = Literal["move_and_wait", "continuous"]


@dataclass(frozen=True, slots=True)
class Autonomy:
    """A way of commanding.

    Attributes:
        name: as tables call it.
        level: the mission's `autonomy`.
        steering: the operator's, where the level is `short_range_goal`.
        waits: the operator sends nothing more until it has heard how its last command ended.
    """

    name: str
    level: Level
    steering: Steering
    waits: bool


MISSION: Final = Autonomy("mission", "mission", "move_and_wait", waits=True)
WAYPOINT: Final = Autonomy("waypoint", "waypoint", "move_and_wait", waits=True)
SHORT_RANGE_GOAL: Final = Autonomy("short_range_goal", "short_range_goal", "move_and_wait", waits=True)
CONTINUOUS: Final = Autonomy("short_range_goal-continuous", "short_range_goal", "continuous", waits=False)
JOINT: Final = Autonomy("joint", "joint", "move_and_wait", waits=False)

AUTONOMIES: Final = {one.name: one for one in (MISSION, WAYPOINT, SHORT_RANGE_GOAL, CONTINUOUS, JOINT)}


def autonomies_of(names: Sequence[str]) -> tuple[Autonomy, ...]:
    """Return the autonomies of these names, in the order of AUTONOMIES.

    Raises:
        InputError: there is none of a name.
    """
    if unknown := [name for name in names if name not in AUTONOMIES]:
        problem = f"--autonomy: {unknown[0]!r} is not an autonomy; choose from {', '.join(AUTONOMIES)}"
        raise InputError(problem, hint="Separate several by commas, as in --autonomy mission,waypoint.")
    return tuple(one for name, one in AUTONOMIES.items() if name in names)
