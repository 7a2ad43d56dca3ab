"""Options that more than one command has."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import typer


def policy_named(text: str) -> Path:
    """Return the folder of the policy that an argument or option names, for `parser=` of it."""
    from waypointctl.mission.policy_name import policy_folder

    return policy_folder(str(text))


def positive(value: float | None) -> float | None:
    """Refuse a number that is not finite and above 0."""
    if value is not None and not (math.isfinite(value) and value > 0):
        raise typer.BadParameter(f"{value} is not a number above 0, such as 1 or 0.5.")
    return value


def not_negative(value: float | None) -> float | None:
    """Refuse a number that is not finite or below 0."""
    if value is not None and not (math.isfinite(value) and value >= 0):
        raise typer.BadParameter(f"{value} is not a number of at least 0.")
    return value


def rate_from(least: float) -> Callable[[float | None], float | None]:
    """Return what refuses a rate that is not from `least` to 1, such as one in per cent."""

    def rate(value: float | None) -> float | None:
        if value is None or least <= value <= 1:
            return value
        meant = f": {value:g} % is {value / 100:g}" if 1 < value <= 100 else ""
        raise typer.BadParameter(f"{value:g} is not a rate from {least:g} to 1{meant}.")

    return rate


def whole_number(least: int, most: int) -> Callable[[object], int]:
    """Return what reads a whole number from `least` to `most`, for `parser=` of an option."""

    def number(text: object) -> int:
        digits = str(text).strip()
        if digits.isascii() and digits.isdecimal() and len(digits) <= 20 and least <= int(digits) <= most:
            return int(digits)
        raise typer.BadParameter(f"{text!s:.40} is not a whole number from {least} to {most}.")

    return number
