"""The exceptions that waypointctl raises on purpose.

    WaypointctlError
    └── InputError         what was given is wrong: exit code 2
        ├── MissionError   a mission file
        ├── RecipeError    a training recipe
        ├── SuiteError     an evaluation suite
        ├── PolicyError    a policy bundle
        ├── RobotError     a robot's folder
        ├── LogError       a log
        └── OutputError    a place that cannot be written

A message states what is wrong, where, what is allowed and how to fix it. The command line catches
WaypointctlError once, at its edge, prints the message without a traceback and exits with `exit_code`.
Anything else that is raised is a bug.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import index
from pathlib import Path
from typing import ClassVar, Final, SupportsIndex

from waypointctl.display_text import printable

_MOST_CHARACTERS: Final = 4000  # of a line of a message; the caller shortens the values in it


class WaypointctlError(Exception):
    """Anything waypointctl refuses to do, with a message for people."""

    exit_code: ClassVar[int] = 1


class InputError(WaypointctlError):
    """What was given is wrong.

    Args:
        problem: what was found and what is allowed, one sentence.
        where: the file, or file:line:column, that it was found at.
        hint: what to do about it; the message begins it with a capital letter.
        details: lines that follow the problem, such as a list of problems.
    """

    exit_code = 2

    def __init__(
        self, problem: str, *, where: str | None = None, hint: str | None = None, details: Sequence[str] = ()
    ) -> None:
        """Join the parts into one message that is fit to show; the attributes keep them as they are."""
        self.problem = problem
        self.where = where
        self.hint = hint
        self.details = tuple(details)
        lines = [f"{printable(where)}: {_line(problem)}" if where else _line(problem), *map(_line, details)]
        if hint:
            lines.append(f"  {_line(hint[0].upper() + hint[1:])}")
        super().__init__("\n".join(lines))


def _line(text: str) -> str:
    return printable(text, _MOST_CHARACTERS)


def wrong_type(argument: str, value: object, allowed: str) -> InputError:
    """Return the error for an argument of a public function that has a type which is not allowed."""
    return InputError(f"{argument}: {type(value).__name__} is not allowed; give {allowed}")


def given_path(argument: str, value: object, what: str) -> Path:
    """Return the path that an argument of a public function has.

    Raises:
        InputError: it is neither a Path nor a str.
    """
    if not isinstance(value, Path | str):
        raise wrong_type(argument, value, f"the path of {what}")
    return Path(value)


def given_number(argument: str, value: object, least: int, most: int) -> int:
    """Return the whole number that an argument of a public function has.

    Raises:
        InputError: it is not one, or not from `least` to `most`.
    """
    if isinstance(value, bool) or not isinstance(value, SupportsIndex) or not least <= index(value) <= most:
        raise InputError(f"{argument} is a whole number from {least} to {most}, not {value!r}")
    return index(value)


class MissionError(InputError):
    """A mission file that cannot be flown."""


class RecipeError(InputError):
    """A training recipe that cannot be followed."""


class SuiteError(InputError):
    """An evaluation suite that cannot be run."""


class PolicyError(InputError):
    """A policy bundle that is missing, damaged, or made for something else."""


class RobotError(InputError):
    """A robot's folder that is missing, or whose robot.yaml or MJCF is wrong."""


class LogError(InputError):
    """A log that cannot be read."""


class OutputError(InputError):
    """A place that cannot be written."""
