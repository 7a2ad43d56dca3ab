"""The result of a replay."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """Whether the replay reproduces the log, and how much of the log was compared.

    EXACT: the replay writes the same file, byte for byte. EQUIVALENT: physics and every message are the same, bit for
    bit; something else could not be compared. APPROXIMATE: the physics is the same, bit for bit; what was computed from
    it is equal within rounding. DIVERGED: the replay differs. UNVERIFIABLE: the log cannot be replayed here.
    """

    EXACT = "exact"
    EQUIVALENT = "equivalent"
    APPROXIMATE = "approximate"
    DIVERGED = "diverged"
    UNVERIFIABLE = "unverifiable"

    @property
    def is_reproduced(self) -> bool:
        """Whether the replay reproduces the flight: EXACT, EQUIVALENT or APPROXIMATE."""
        return self in (Verdict.EXACT, Verdict.EQUIVALENT, Verdict.APPROXIMATE)


@dataclass(frozen=True, slots=True)
class Divergence:
    """The first difference between a log and its replay."""

    step: int  # the control step; -1 for the file and its attachments
    time_ns: int
    topic: str
    component: str
    logged: str
    replayed: str

    @property
    def place(self) -> str:
        """The place as text."""
        if self.step >= 0:
            return f"at step {self.step} on {self.topic}, {self.component}"
        return f"in the file: {self.component if self.topic == 'file' else f'{self.topic}, {self.component}'}"


@dataclass(frozen=True, slots=True)
class Verification:
    """A verdict with its reasons.

    Attributes:
        verdict: how far the replay reproduces the flight.
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


def verification_json(verification: Verification) -> dict[str, object]:
    """Return the verdict with its reasons."""
    first = verification.first_divergence
    return {
        "verdict": str(verification.verdict),
        "steps": verification.steps,
        "first_divergence": None if first is None else asdict(first),
        "reason": verification.reason,
        "checks": list(verification.checks),
        "not_compared": list(verification.not_compared),
    }
