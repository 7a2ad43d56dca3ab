"""The kinds of number that a recipe's fields hold, with their bounds."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field, Strict

Count: TypeAlias = Annotated[int, Strict(), Field(gt=0, le=10**12)]
Few: TypeAlias = Annotated[int, Strict(), Field(gt=0, le=65_536)]  # of what takes memory
Fraction: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1)]
Rate: TypeAlias = Annotated[float, Strict(), Field(gt=0, le=1)]
Factor: TypeAlias = Annotated[float, Strict(), Field(gt=0, le=1000, allow_inf_nan=False)]
