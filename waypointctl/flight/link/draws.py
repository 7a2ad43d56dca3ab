"""Random numbers one after the other, drawn from their stream many at a time: a tenth of the work, the same numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final, Generic, TypeVar

import numpy as np

T = TypeVar("T")

BLOCK: Final = 256


class Draws(Generic[T]):
    """What one stream gives, one by one.

    numpy gives the same numbers whether they are drawn singly or many at once (a test holds it to that), so
    nothing but the time depends on the block.
    """

    __slots__ = ("_ahead", "_begin", "_draw", "_rng")

    def __init__(self, rng: np.random.Generator, draw: Callable[[np.random.Generator, int], list[T]]) -> None:
        """Take a stream, and a function that draws a given number of values from it."""
        self._rng = rng
        self._draw = draw
        self._begin: Mapping[str, Any] = rng.bit_generator.state  # of the stream, before the block
        self._ahead: list[T] = []  # of the block, the next one last

    def __call__(self) -> T:
        """Return the next one."""
        if not self._ahead:
            self._fill()
        return self._ahead.pop()

    def state(self) -> dict[str, Any]:
        """Return what the next ones depend on, as plain data."""
        used = BLOCK - len(self._ahead) if self._ahead else 0
        return {"stream": dict(self._begin if used else self._rng.bit_generator.state), "used": used}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go on where `state` was taken."""
        self._rng.bit_generator.state = state["stream"]
        self._ahead = []
        if state["used"]:
            self._fill()
            del self._ahead[BLOCK - state["used"] :]

    def _fill(self) -> None:
        self._begin = self._rng.bit_generator.state
        self._ahead = self._draw(self._rng, BLOCK)
        self._ahead.reverse()


def chances(rng: np.random.Generator) -> Draws[float]:
    """Return numbers that lie evenly in [0, 1)."""
    return Draws(rng, lambda stream, count: stream.random(count).tolist())
