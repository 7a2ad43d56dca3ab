"""What a replay proves."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """Whether the log's flight happens again, and how much of the log was compared.

    The first three say that it does: EXACT that the replay writes the same file, byte for byte; EQUIVALENT that the
    physics and every message are the same, bit for bit, and something else could not be compared; APPROXIMATE that
    the physics is the same, bit for bit, and what was computed from it the same within rounding.
    """

    EXACT = "exact"
    EQUIVALENT = "equivalent"
    APPROXIMATE = "approximate"
    DIVERGED = "diverged"
    UNVERIFIABLE = "unverifiable"

    @property
    def is_proof(self) -> bool:
        """Whether it says that the flight happens again."""
        return self in (Verdict.EXACT, Verdict.EQUIVALENT, Verdict.APPROXIMATE)


@dataclass(frozen=True, slots=True)
class Divergence:
    """Where the log and its replay part."""

    step: int  # the control step; -1 for what is not of a control step: the file, what it carries
    time_ns: int
    topic: str
    component: str
    logged: str
    replayed: str

    @property
    def place(self) -> str:
        """Where it is, in words."""
        if self.step >= 0:
            return f"at step {self.step} on {self.topic}, {self.component}"
        return f"in the file: {self.component if self.topic == 'file' else f'{self.topic}, {self.component}'}"


@dataclass(frozen=True, slots=True)
class Verification:
    """A verdict and what it rests on.

    Attributes:
        verdict: how far the flight happened again.
        steps: control steps that were replayed and found equal.
        first_divergence: where it diverged, if it did.
        reason: the verdict in a sentence.
        checks: what was compared, a line each.
        not_compared: what was not compared, or not bit for bit, and why, a line each; empty where all was.
    """

    verdict: Verdict
    steps: int
    first_divergence: Divergence | None
    reason: str
    checks: tuple[str, ...]
    not_compared: tuple[str, ...] = ()
