"""What a mission as a whole has to be, beyond the bounds of its fields."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Final, Literal

from pydantic_core import InitErrorDetails

from waypointctl.display_text import shown
from waypointctl.mission.fields import error_at, raise_errors
from waypointctl.mission.operator import ScheduledCommand

SCHEMA_VERSION: Final[Literal[2]] = 2
# A mission's name becomes a file's name.
_FILE_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9._ -]*")


def file_name(name: str) -> str:
    """Return a name that can name a file on any system.

    Raises:
        ValueError: it cannot.
    """
    if not _FILE_NAME.fullmatch(name) or name.endswith((" ", ".")):
        raise ValueError(f"{name!r} is not a name of letters, digits, '.', '_', '-' and spaces between them")
    return name


def known_version(version: object) -> object:
    """Return the version of a mission's keys.

    Raises:
        ValueError: it is not the one that is read.
    """
    if type(version) is not int or version != SCHEMA_VERSION:
        raise ValueError(f"version {shown(version)} is not supported; supported: {SCHEMA_VERSION}")
    return version


def names_differ(names: Sequence[str]) -> None:
    """Check that no two waypoints go by the same name.

    Raises:
        ValidationError: some do, each of them named.
    """
    first: dict[str, int] = {}
    errors = []
    for index, name in enumerate(names):
        if name in first:
            problem = f"{name!r} is the name of waypoints[{first[name]}] already"
            errors.append(error_at(problem, (index, "name"), name))
        first.setdefault(name, index)
    raise_errors("waypoints", errors)


def expected_within(reached: int | str, count: int) -> None:
    """Check that a mission expects no more waypoints to be reached than the `count` that it has.

    Raises:
        ValidationError: it does.
    """
    if isinstance(reached, int) and reached > count:
        problem = f"{reached} is more than the {count} waypoints of the mission"
        raise_errors("expect", [error_at(problem, ("reached",), reached)])


def possible(schedule: Sequence[ScheduledCommand], released: int, autonomy: str, count: int) -> None:
    """Check that no waypoints are released, and no commands cancelled, that there can never be.

    Args:
        schedule: of the mission.
        released: waypoints at mission start; -1 for all.
        autonomy: of the mission.
        count: of its waypoints, in all rounds.

    Raises:
        ValidationError: some are, each of them named.
    """
    raise_errors("mission", [*_released(schedule, released, count), *_cancelled(schedule, autonomy, count)])


def _released(schedule: Sequence[ScheduledCommand], at_start: int, count: int) -> Iterator[InitErrorDetails]:
    """Yield what releases more waypoints than there are; no command makes the plan longer."""
    given: list[tuple[tuple[str | int, ...], int]] = [(("operator", "released"), at_start)]
    given += [(("schedule", place, "released"), each.released or 0) for place, each in enumerate(schedule)]
    for loc, released in given:
        if released > count:
            plan = f"{count} waypoint{'s' * (count > 1)} of the plan"
            yield error_at(f"{released} is more than the {plan}; write -1 to release them all", loc, released)


def _cancelled(schedule: Sequence[ScheduledCommand], autonomy: str, count: int) -> Iterator[InitErrorDetails]:
    """Yield what cancels a command that cannot have been sent by then: each gets its number when it is sent."""
    own = _most_own_commands(autonomy, count)
    if own is None:
        return
    in_turn = sorted(range(len(schedule)), key=lambda place: schedule[place].at_s)
    for earlier, place in enumerate(in_turn):
        command = schedule[place].command
        if command is not None and command > own + earlier:
            sent = f"at most {own + earlier} {'is' if own + earlier == 1 else 'are'} sent before this one"
            problem = (
                f"no command {command} can have been sent by then: under autonomy {autonomy} {sent} (they "
                "count from 1, in the order of sending)"
            )
            yield error_at(problem, ("schedule", place, "command"), command)


def _most_own_commands(autonomy: str, count: int) -> int | None:
    """Return how many commands the operator sends at most, beside the schedule; None where that is unknown."""
    if autonomy == "short_range_goal":
        return None
    if autonomy == "mission":
        return 1
    # One a waypoint; a pilot's last command may be to hold once time is out.
    return count + (autonomy == "joint")
