"""What several parts of a mission are made of: names, places, and the bounds of times and lengths."""

from __future__ import annotations

from typing import Annotated, Final, Literal, TypeAlias

from pydantic import AfterValidator, Field

from waypointctl.mission.checks import line_of_text
from waypointctl.mission.quantity import Quantity

DAY_S: Final = 86_400.0
FURTHEST_M: Final = 10_000.0  # of a coordinate

Name: TypeAlias = Annotated[str, Field(min_length=1, max_length=60), AfterValidator(line_of_text)]
Coordinate: TypeAlias = Annotated[float, Quantity("m", ge=-FURTHEST_M, le=FURTHEST_M)]
Position: TypeAlias = tuple[Coordinate, Coordinate]
Acceptance: TypeAlias = Literal["box", "radius"]
Tolerance: TypeAlias = Annotated[float, Quantity("m", gt=0, le=100)]
Timeout: TypeAlias = Annotated[float, Quantity("s", gt=0, le=DAY_S)]
Hold: TypeAlias = Annotated[float, Quantity("s", ge=0, le=DAY_S)]
