"""Options that more than one command has."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import typer

PluginFiles: TypeAlias = Annotated[
    list[Path] | None,
    typer.Option(
        "--plugin",
        metavar="FILE.py",
        help="Execute this Python file, with observation groups and reward terms of the policy; repeatable.",
    ),
]


def policy_named(text: str) -> Path:
    """Return the folder of the policy that an option names, for `parser=` of the option."""
    from waypointctl.mission.policy_name import policy_folder

    return policy_folder(str(text))


def positive(text: object) -> float:
    """Read a finite number above 0, for `parser=` of an option."""
    value = _number(text)
    if math.isfinite(value) and value > 0:
        return value
    raise typer.BadParameter(f"{text!s:.40} is not a number above 0, such as 1 or 0.5.")


def number_to(most: float) -> Callable[[object], float]:
    """Return the parser of a number from 0 to `most`, for `parser=` of an option."""

    def number(text: object) -> float:
        value = _number(text)
        if math.isfinite(value) and 0 <= value <= most:
            return value
        allowed = f"from 0 to {most:g}" if math.isfinite(most) else "of at least 0"
        raise typer.BadParameter(f"{text!s:.40} is not a number {allowed}.")

    return number


def rate_from(least: float) -> Callable[[object], float]:
    """Return the parser of a rate from `least` to 1; the message suggests the rate for a percentage."""

    def rate(text: object) -> float:
        value = _number(text)
        if least <= value <= 1:
            return value
        suggestion = f": {value:g} % is {value / 100:g}" if 1 < value <= 100 else ""
        raise typer.BadParameter(f"{text!s:.40} is not a rate from {least:g} to 1{suggestion}.")

    return rate


def whole_number(least: int, most: int) -> Callable[[object], int]:
    """Return the parser of a whole number from `least` to `most`, for `parser=` of an option."""

    def number(text: object) -> int:
        digits = str(text).strip()
        if digits.isascii() and digits.isdecimal() and len(digits) <= 20 and least <= int(digits) <= most:
            return int(digits)
        raise typer.BadParameter(f"{text!s:.40} is not a whole number from {least} to {most}.")

    return number


def parsed(metavar: str, parser: Callable[[Any], Any], text: str, **shown: Any) -> Any:
    """Return an option that is read by `parser`; `text` is its help."""
    return typer.Option(metavar=metavar, parser=parser, help=text, **shown)


def whole(least: int, most: int, text: str, **shown: Any) -> Any:
    """Return an option that takes a whole number from `least` to `most`."""
    return parsed("N", whole_number(least, most), text, **shown)


def _number(text: object) -> float:
    """Return the number in a text, NaN if the text is not a number."""
    try:
        return float(str(text))
    except ValueError:
        return math.nan
