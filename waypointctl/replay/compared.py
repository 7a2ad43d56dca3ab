"""What a replay compared and what it could not compare, in words; the verdict follows from it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Self

from waypointctl.flight.header import POLICY_FOLDER, PolicyNotInLog
from waypointctl.policy.manifest import NETWORK, WEIGHTS
from waypointctl.policy.weights import weights_fault
from waypointctl.replay.comparator import ACTION_TOLERANCE, LogComparator, RecordedPolicy
from waypointctl.replay.contents import LogContents
from waypointctl.replay.difference import ROUNDING
from waypointctl.replay.recorded_camera import RecordedCamera
from waypointctl.replay.verdict import Verdict, Verification
from waypointctl.replay.whole_file import WholeFile

_SAME: Final = {
    Verdict.EXACT: "every bit the same",
    Verdict.EQUIVALENT: "physics and messages the same, bit for bit",
    Verdict.APPROXIMATE: "the physics the same, bit for bit, the rest within rounding",
}
_NOUNS: Final = {
    "/observation": "observation",
    "/telemetry": "telemetry frame",
    "/ground_control": "action computed on the ground",
}


@dataclass(frozen=True, slots=True)
class Compared:
    """What a replay that found no difference rests on.

    Attributes:
        checks: what was compared, a line each.
        rounded: what is the same within rounding alone, a line each.
        not_compared: what was not compared, and why, a line each.
    """

    checks: tuple[str, ...]
    rounded: tuple[str, ...]
    not_compared: tuple[str, ...]

    @classmethod
    def of(
        cls,
        contents: LogContents,
        comparator: LogComparator,
        policy: RecordedPolicy,
        pictures: RecordedCamera,
        whole: WholeFile,
    ) -> Self:
        """Ask all who compared."""
        not_in_log = isinstance(contents.policy, PolicyNotInLog)
        return cls(
            checks=(*_checks(comparator.compared, computed=not not_in_log), *pictures.checks, *whole.checks),
            rounded=tuple(_rounded(comparator, policy)),
            not_compared=(*_policy_faults(contents, comparator.compared), *pictures.not_compared, *whole.not_compared),
        )

    def verification(self, steps: int) -> Verification:
        """Return the verdict on a flight of `steps` control steps that happened again."""
        unlike = Verdict.APPROXIMATE if self.rounded else Verdict.EQUIVALENT
        verdict = unlike if self.rounded or self.not_compared else Verdict.EXACT
        reason = f"{steps} control steps replayed, {_SAME[verdict]}"
        return Verification(verdict, steps, None, reason, self.checks, (*self.rounded, *self.not_compared))


def _policy_faults(contents: LogContents, counts: Counter[str]) -> Iterator[str]:
    policy = contents.policy
    if isinstance(policy, PolicyNotInLog):
        actions = _several(counts["/action"] + counts["/ground_control"], "action")
        yield f"{actions}, not computed again: the policy, {policy.class_name}, is not in the log"
    elif fault := weights_fault(policy.files[WEIGHTS], policy.files[NETWORK]):
        yield f"{POLICY_FOLDER}{WEIGHTS}: {fault}"


def _checks(counts: Counter[str], *, computed: bool) -> tuple[str, ...]:
    seen, done = _several(counts["/observation"], "observation"), _several(counts["/action"], "action")
    typed = (f"{_several(counts['/console'], 'line')} typed at the console, each at its time",)
    return (
        f"{_several(counts['/state'], 'state')}, simulated from the first one and the logged actions alone",
        f"{seen} and {done}, computed again by the network" if computed else f"{seen}, computed again",
        f"{_several(counts['/reward'], 'reward')}, every term and sum",
        f"{_several(counts['/event'], 'event')}, {_several(counts['/link'], 'message')} that the link lost, doubled or "
        "let wait",
        f"{_several(counts['/command'], 'command')}, {_several(counts['/command_stage'], 'command stage')}, "
        f"{_several(counts['/ack'], 'acknowledgement')} and {_several(counts['/telemetry'], 'telemetry frame')}, with "
        "each time of delivery",
        f"{_several(counts['/checkpoint'], 'checkpoint')}, with the link's random streams",
        *(typed if counts["/console"] else ()),
    )


def _rounded(comparator: LogComparator, policy: RecordedPolicy) -> list[str]:
    lines = [
        f"{_several(count, _NOUNS[topic])}: equal within {ROUNDING:.0e}, not bit for bit"
        for topic, count in comparator.rounded.items()
    ]
    if policy.rounded:
        actions = _several(policy.rounded, "action")
        lines.append(f"{actions} of the network: equal within {ACTION_TOLERANCE:.0e}, not bit for bit")
    return lines


def _several(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
