"""What one way of a link has to be beyond the bounds of its fields."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import PurePosixPath
from typing import TYPE_CHECKING

from pydantic import ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

if TYPE_CHECKING:
    from waypointctl.mission.link import DelayAt, Window


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
        _error(f"{after.at_s:g} s is not after the {before.at_s:g} s of the row before", (index, "at_s"), after.at_s)
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
        _error(f"{each.to_s:g} s is not after {each.from_s:g} s", (index, "to_s"), each.to_s)
        for index, each in enumerate(windows)
        if each.to_s <= each.from_s
    ]
    errors += [
        _error(
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
        raise ValueError("there are no 'windows' that could come again")
    if every_s is not None and windows and windows[-1].to_s > every_s:
        raise ValueError(f"{every_s:g} s is over before the last window ends, at {windows[-1].to_s:g} s")


def alone(name: str, given: object, others: dict[str, object]) -> None:
    """Check that what says the same in another way is not there too.

    Args:
        name: of the field.
        given: its value, as far as it says something.
        others: the fields that say the same, and their values.

    Raises:
        ValueError: one of them is.
    """
    also = [other for other, value in others.items() if value]
    if given and also:
        raise ValueError(f"'{name}' is there, and '{also[0]}' too: keep one")


def _error(problem: str, loc: tuple[str | int, ...], value: object) -> InitErrorDetails:
    kind = PydanticCustomError("link", "{problem}", {"problem": problem})
    return InitErrorDetails(type=kind, loc=loc, input=value)


def _raise(title: str, errors: list[InitErrorDetails]) -> None:
    if errors:
        raise ValidationError.from_exception_data(title, errors)
