"""What a replay proves."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """Whether the log's flight happens again."""

    EXACT = "exact"
    DIVERGED = "diverged"
    UNVERIFIABLE = "unverifiable"


@dataclass(frozen=True, slots=True)
class Divergence:
    """Where the log and its replay part."""

    step: int  # the control step; -1 for what stands before the flight
    time_ns: int
    topic: str
    component: str
    logged: str
    replayed: str


@dataclass(frozen=True, slots=True)
class Verification:
    """A verdict and what it rests on.

    Attributes:
        verdict: exact, diverged or unverifiable.
        steps: control steps that were replayed and found equal.
        first_divergence: where it diverged, if it did.
        reason: the verdict in a sentence.
        checks: what was compared, a line each.
    """

    verdict: Verdict
    steps: int
    first_divergence: Divergence | None
    reason: str
    checks: tuple[str, ...]
