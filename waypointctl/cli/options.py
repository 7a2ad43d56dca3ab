"""Options that more than one command has."""

from __future__ import annotations

import math

import typer


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
