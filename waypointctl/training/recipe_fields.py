"""The kinds of number that a recipe's fields hold, with their bounds."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field, Strict

from waypointctl.mission.quantity import Quantity

Count: TypeAlias = Annotated[int, Strict(), Field(gt=0, le=10**12)]
Few: TypeAlias = Annotated[int, Strict(), Field(gt=0, le=65_536)]  # of what takes memory
Fraction: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1)]
Rate: TypeAlias = Annotated[float, Strict(), Field(gt=0, le=1)]
# Bounds that no sound training comes near, and below which float32 does not overflow at the first step.
Cost: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1e6, allow_inf_nan=False)]
Factor: TypeAlias = Annotated[float, Strict(), Field(gt=0, le=1000, allow_inf_nan=False)]
Place: TypeAlias = Annotated[float, Quantity("m", ge=-10_000, le=10_000)]
Duration: TypeAlias = Annotated[float, Quantity("s", gt=0, le=86_400)]
