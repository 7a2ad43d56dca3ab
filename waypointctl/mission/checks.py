"""What a mission has to be beyond the bounds of its fields: of one field, of a direction of the link, of the whole."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Final, Literal

from pydantic import ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

from waypointctl.display_text import shown

if TYPE_CHECKING:
    from waypointctl.mission.link import DelayAt, Window
    from waypointctl.mission.mission import Mission, Waypoint

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
        raise ValueError(f"{shown(version)} is not the version that is read; write {SCHEMA_VERSION}, or leave it out")
    return version


def line_of_text(text: str) -> str:
    """Return a text that fits in a line.

    Raises:
        ValueError: it has line breaks or other control characters.
    """
    if not text.isprintable():
        raise ValueError(f"{text!r} is not one line of text without control characters")
    return text


def names_differ(waypoints: tuple[Waypoint, ...]) -> tuple[Waypoint, ...]:
    """Return waypoints of which no two go by the same name.

    Raises:
        ValidationError: some do, each of them named.
    """
    first: dict[str, int] = {}
    errors = []
    for index, waypoint in enumerate(waypoints):
        name = waypoint.name if waypoint.name is not None else f"WP{index + 1}"
        if name in first:
            problem = f"{name!r} is the name of waypoints[{first[name]}] already"
            errors.append(error_at(problem, (index, "name"), name))
        first.setdefault(name, index)
    _raise("waypoints", errors)
    return waypoints


def jitter_within(jitter_s: float, delay_s: float | None) -> float:
    """Return a jitter that leaves the delay positive; a delay of None is reported already.

    Raises:
        ValueError: it is more than the delay.
    """
    if delay_s is not None and jitter_s > delay_s:
        raise ValueError(f"{jitter_s:g} s is more than the delay of {delay_s:g} s")
    return jitter_s


def expected_within(reached: int | str, count: int) -> None:
    """Check that a mission expects no more waypoints to be reached than the `count` that it has.

    Raises:
        ValidationError: it does.
    """
    if isinstance(reached, int) and reached > count:
        problem = f"{reached} is more than the {count} waypoints of the mission"
        _raise("expect", [error_at(problem, ("reached",), reached)])


def error_at(problem: str, loc: tuple[str | int, ...], value: object) -> InitErrorDetails:
    """Return a problem with a value somewhere below what is being checked, for a ValidationError."""
    kind = PydanticCustomError("mission", "{problem}", {"problem": problem})
    return InitErrorDetails(type=kind, loc=loc, input=value)


def file_beside(name: str) -> str:
    """Return the name of a file that a log can carry: one beside the mission file or below its folder.

    Raises:
        ValueError: it leads elsewhere.
    """
    path = PurePosixPath(name)
    if path.is_absolute() or ".." in path.parts or "\\" in name or str(path) != name:
        raise ValueError(f"{name!r} is not a file beside the mission or below its folder: write 'plan.ionrc' or 'a/b'")
    return name


def times_rise(rows: tuple[DelayAt, ...]) -> tuple[DelayAt, ...]:
    """Return the rows of a table whose times rise.

    Raises:
        ValidationError: some do not, each of them named.
    """
    errors = [
        error_at(f"{after.at_s:g} s is not after the {before.at_s:g} s of the row before", (index, "at_s"), after.at_s)
        for index, (before, after) in enumerate(pairwise(rows), 1)
        if after.at_s <= before.at_s
    ]
    _raise("delay_table", errors)
    return rows


def in_order(windows: tuple[Window, ...]) -> tuple[Window, ...]:
    """Return windows that begin before they end, after the one before.

    Raises:
        ValidationError: some do not, each of them named.
    """
    errors = [
        error_at(f"{each.to_s:g} s is not after {each.from_s:g} s", (index, "to_s"), each.to_s)
        for index, each in enumerate(windows)
        if each.to_s <= each.from_s
    ]
    errors += [
        error_at(
            f"{after.from_s:g} s is before the {before.to_s:g} s at which the window before ends",
            (index, "from_s"),
            after.from_s,
        )
        for index, (before, after) in enumerate(pairwise(windows), 1)
        if after.from_s < before.to_s
    ]
    _raise("windows", errors)
    return windows


def windows_within(every_s: float | None, windows: Sequence[Window] | None) -> None:
    """Check that there are windows, and that they fit in the time after which they come again.

    Raises:
        ValueError: they do not, or there are none.
    """
    if every_s is not None and windows is None:
        raise ValueError("needs 'windows'")
    if every_s is not None and windows and windows[-1].to_s > every_s:
        raise ValueError(f"{every_s:g} s ends before the last window, which ends at {windows[-1].to_s:g} s")


def alone(name: str, given: object, others: dict[str, object]) -> None:
    """Check that no alternative field is given too.

    Args:
        name: of the field.
        given: its value.
        others: the alternative fields, and their values.

    Raises:
        ValueError: one of them is.
    """
    also = [other for other, value in others.items() if value]
    if given and also:
        raise ValueError(f"'{name}' and '{also[0]}' are both given: keep one")


def _raise(title: str, errors: list[InitErrorDetails]) -> None:
    if errors:
        raise ValidationError.from_exception_data(title, errors)


def possible(mission: Mission) -> None:
    """Check that no waypoints are released, and no commands cancelled, that there can never be.

    Raises:
        ValidationError: some are, each of them named.
    """
    _raise("mission", [*_released(mission), *_cancelled(mission)])


def _released(mission: Mission) -> Iterator[InitErrorDetails]:
    """Yield what releases more waypoints than there are; no command makes the plan longer."""
    count = mission.num_legs
    given: list[tuple[tuple[str | int, ...], int]] = [(("operator", "released"), mission.operator.released)]
    given += [(("schedule", place, "released"), each.released or 0) for place, each in enumerate(mission.schedule)]
    for loc, released in given:
        if released > count:
            plan = f"{count} waypoint{'s' * (count > 1)} of the plan"
            yield error_at(f"{released} is more than the {plan}; write -1 to release them all", loc, released)


def _cancelled(mission: Mission) -> Iterator[InitErrorDetails]:
    """Yield what cancels a command that cannot have been sent by then: each gets its number when it is sent."""
    own = _most_own_commands(mission)
    if own is None:
        return
    in_turn = sorted(range(len(mission.schedule)), key=lambda place: mission.schedule[place].at_s)
    for earlier, place in enumerate(in_turn):
        command = mission.schedule[place].command
        if command is not None and command > own + earlier:
            sent = f"at most {own + earlier} {'is' if own + earlier == 1 else 'are'} sent before this one"
            problem = (
                f"no command {command} can have been sent by then: under autonomy {mission.autonomy} {sent} (they "
                "count from 1, in the order of sending)"
            )
            yield error_at(problem, ("schedule", place, "command"), command)


def _most_own_commands(mission: Mission) -> int | None:
    """Return how many commands the operator sends at most, beside the schedule; None where that is unknown."""
    if mission.autonomy == "short_range_goal":
        return None
    if mission.autonomy == "mission":
        return 1
    # One a waypoint; a pilot's last command may be to hold once time is out.
    return mission.num_legs + (mission.autonomy == "joint")
