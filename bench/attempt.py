"""How far a training came, and how long it took without its tests."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from time import perf_counter


@dataclass(frozen=True, slots=True)
class Look:
    """A test of a policy in training, after so many control steps and seconds of training, tests left out."""

    steps: int
    training_s: float
    success_rate: float


@dataclass(frozen=True, slots=True)
class Attempt:
    """How far a training came."""

    looks: tuple[Look, ...]
    target: float

    @property
    def reached(self) -> Look | None:
        """The first test that met the target."""
        return next((look for look in self.looks if look.success_rate >= self.target), None)

    @property
    def end(self) -> Look:
        """The test that met the target, or the last."""
        return self.reached or self.looks[-1]

    @property
    def best(self) -> float:
        """The highest success rate of all tests."""
        return max(look.success_rate for look in self.looks)


class Stopwatch:
    """Time since it was made, pauses left out."""

    def __init__(self) -> None:
        """Begin."""
        self._begun_s = perf_counter()

    @property
    def seconds(self) -> float:
        """Until now, outside pauses."""
        return perf_counter() - self._begun_s

    @contextmanager
    def pause(self) -> Iterator[None]:
        """Leave out what happens inside."""
        begun_s = perf_counter()
        yield
        self.leave_out(perf_counter() - begun_s)

    def leave_out(self, time_s: float) -> None:
        """Leave out a time that has passed."""
        self._begun_s += time_s
