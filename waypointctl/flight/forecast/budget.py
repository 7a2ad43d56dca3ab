"""How much may be rehearsed for one forecast: a forecast is an answer at once, or no answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

MOST_STEPS: Final = 40_000  # of all rehearsals of a mission; two or three seconds


@dataclass(slots=True)
class Budget:
    """Steps that are left, shared by all that is rehearsed of a mission."""

    left: int = MOST_STEPS

    def spend(self) -> bool:
        """Take one step; tell whether there was one."""
        self.left -= 1
        return self.left >= 0
