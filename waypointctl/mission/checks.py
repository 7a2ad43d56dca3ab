"""What a mission has to be beyond the bounds of its fields."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final

from pydantic import ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

if TYPE_CHECKING:
    from waypointctl.mission.mission import Waypoint

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
    if errors:
        raise ValidationError.from_exception_data("waypoints", errors)
    return waypoints


def jitter_within(jitter_s: float, delay_s: float | None) -> float:
    """Return a jitter that leaves the delay positive; a delay of None is wrong already and says so itself.

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
        raise ValidationError.from_exception_data("expect", [error_at(problem, ("reached",), reached)])


def error_at(problem: str, loc: tuple[str | int, ...], value: object) -> InitErrorDetails:
    """Return a problem with a value somewhere below what is being checked, for a ValidationError."""
    kind = PydanticCustomError("mission", "{problem}", {"problem": problem})
    return InitErrorDetails(type=kind, loc=loc, input=value)
