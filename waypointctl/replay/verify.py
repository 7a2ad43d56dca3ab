"""Verification: simulates the flight again from the log alone, and compares it bit for bit."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path
from typing import Final

from waypointctl.errors import InputError, given_path
from waypointctl.flight.fly import fly
from waypointctl.flight.header import POLICY_FOLDER, platform_facts
from waypointctl.flight.policy_fit import PolicyNotInLog
from waypointctl.flight.sink import with_pictures
from waypointctl.log.comparison import Diverged, Divergence
from waypointctl.log.messages import Message
from waypointctl.log.reader import LogReader, open_log
from waypointctl.policy.manifest import NETWORK, WEIGHTS
from waypointctl.policy.network import weights_fault
from waypointctl.replay.comparator import ROUNDING, LogComparator, LogEnded
from waypointctl.replay.contents import KERNELS, LogContents, contents_of, platform_differences, unverifiable
from waypointctl.replay.recorded import ACTION_TOLERANCE, RecordedCamera, RecordedConsole, RecordedPolicy
from waypointctl.replay.summary_builder import summary_of_events
from waypointctl.replay.whole_file import WholeFile, whole_file
from waypointctl.task.plugins import Plugin, Plugins, load_plugins


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
class Verification:
    """A verdict with its reasons."""

    verdict: Verdict  # how far the replay reproduces the flight
    steps: int  # control steps that were replayed and found equal
    first_divergence: Divergence | None  # where it diverged, if it did
    reason: str  # the verdict in a sentence
    checks: tuple[str, ...]  # what was compared, a line each
    # what was not compared, or not bit for bit, and why, a line each; empty where all was
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


def verify(path: Path | str, plugins: Plugins = ()) -> Verification:
    """Simulate the flight of a log from the log alone, and compare every message and byte.

    Args:
        path: of the log.
        plugins: observation groups and reward terms that it was flown with and that are not built in: themselves, or
            the paths of their Python files, which are executed. Without one that the log names it is unverifiable.

    Raises:
        LogError: the log cannot be read.
        InputError: an argument has a wrong type, or a plugin is missing or fails.
    """
    return verify_log(open_log(given_path("path", path, "a log")), load_plugins(plugins))


def verify_log(log: LogReader, plugins: Sequence[Plugin] = ()) -> Verification:
    """Simulate the flight of a log and compare the whole log.

    Everything comes from the log: mission, model, policy, seed. Physics is driven by the logged actions, each of
    which is computed again from the observation. States, observations, actions, reward terms and sums, events,
    commands, acknowledgements and telemetry with their times of delivery, and checkpoints have to be equal. Pictures
    are drawn again where the same renderer is. The log is written anew on the way, and compared with the file byte
    for byte. What it says of the program and processor that wrote it cannot be compared elsewhere: then the verdict
    is a lower one.

    Raises:
        LogError: the log cannot be read.
    """
    if reason := unverifiable(log):
        return Verification(Verdict.UNVERIFIABLE, 0, None, reason, ())
    try:
        contents = contents_of(log, plugins)
    except InputError as error:
        reason = f"the contents of the log cannot be used: {'. '.join(map(str.strip, str(error).splitlines()))}"
        return Verification(Verdict.UNVERIFIABLE, 0, None, reason, ())
    if isinstance(contents, Divergence):
        reason = f"diverged before the flight: {contents.component} differs from its recorded hash"
        return Verification(Verdict.DIVERGED, 0, contents, reason, ())
    return _fly_again(log, contents)


def _fly_again(log: LogReader, contents: LogContents) -> Verification:
    other_kernels = platform_differences(log, KERNELS)
    comparator = LogComparator(log.encoded_messages(), bitwise=not other_kernels)
    policy = RecordedPolicy(contents.policy, comparator, bitwise=not other_kernels)
    try:
        with contents.camera as camera, whole_file(log, contents) as whole:
            pictures = RecordedCamera(camera, comparator)

            def take(message: Message) -> None:
                whole(comparator(message))

            by_hand = RecordedConsole(comparator, contents.mission, summary_of_events(log))
            fly(
                contents.mission,
                policy,
                with_pictures(take, pictures),
                robot=contents.robot,
                interrupted=by_hand.interrupted,
                console=by_hand,
                plugins=contents.plugins,
            )
            if comparator.upcoming is not None:
                raise comparator.diverged("/event", "end", type(comparator.upcoming).__name__, "the flight has ended")
            whole.finish()
            return _reproduced(contents, comparator, policy, pictures, whole)
    except Diverged as error:
        if error.rounding and other_kernels:
            reason = (
                f"rounded differently at step {error.where.step} on {error.where.topic}: {', '.join(other_kernels)}"
            )
            return Verification(Verdict.UNVERIFIABLE, comparator.compared["/reward"], error.where, reason, ())
        return _diverged(error.where, comparator, log)
    except LogEnded:
        ended = comparator.diverged("/event", "end", "the log ends", "the flight continues")
        return _diverged(ended.where, comparator, log)


def _diverged(where: Divergence, comparator: LogComparator, log: LogReader) -> Verification:
    reason = f"diverged {where.place}"
    wrote, here = _software(log.metadata), _software(platform_facts())
    if wrote != here:
        reason += f" (waypointctl {wrote} wrote the log, this is {here}: the other program may be the cause)"
    return Verification(Verdict.DIVERGED, comparator.compared["/reward"], where, reason, ())


def _software(facts: Mapping[str, str]) -> str:
    return f"{facts.get('version_waypointctl')} ({facts.get('source')})"


_SAME: Final = {
    Verdict.EXACT: "identical byte for byte",
    Verdict.EQUIVALENT: "physics and messages identical bit for bit",
    Verdict.APPROXIMATE: "physics identical bit for bit, the rest equal within rounding",
}
_NOUNS: Final = {
    "/observation": "observation",
    "/telemetry": "telemetry frame",
    "/ground_control": "action computed on the ground",
}


def _reproduced(
    contents: LogContents, comparator: LogComparator, policy: RecordedPolicy, pictures: RecordedCamera, whole: WholeFile
) -> Verification:
    """Return the verdict on a flight of which no comparison has found a difference."""
    counts = comparator.compared
    checks = _checks(counts, computed=not isinstance(contents.policy, PolicyNotInLog))
    rounded = _rounded(comparator, policy)
    not_compared = (*_policy_faults(contents, counts), *pictures.not_compared, *whole.not_compared)
    unlike = Verdict.APPROXIMATE if rounded else Verdict.EQUIVALENT
    verdict = unlike if rounded or not_compared else Verdict.EXACT
    reason = f"{counts['/action']} control steps replayed, {_SAME[verdict]}"
    every = (*checks, *pictures.checks, *whole.checks)
    return Verification(verdict, counts["/action"], None, reason, every, (*rounded, *not_compared))


def _policy_faults(contents: LogContents, counts: Counter[str]) -> Iterator[str]:
    policy = contents.policy
    if isinstance(policy, PolicyNotInLog):
        actions = _several(counts["/action"] + counts["/ground_control"], "action")
        yield f"{actions}, not recomputed: the policy class {policy.class_name} is not in the log"
    elif fault := weights_fault(policy.files[WEIGHTS], policy.files[NETWORK]):
        yield f"{POLICY_FOLDER}{WEIGHTS}: {fault}"


def _checks(counts: Counter[str], *, computed: bool) -> tuple[str, ...]:
    seen, done = _several(counts["/observation"], "observation"), _several(counts["/action"], "action")
    typed = (f"{_several(counts['/console'], 'line')} typed at the console, each at its logged time",)
    return (
        f"{_several(counts['/state'], 'state')}, simulated from the first state and the logged actions alone",
        f"{seen} and {done}, recomputed by the network" if computed else f"{seen}, recomputed",
        f"{_several(counts['/reward'], 'reward')}, every term and sum",
        f"{_several(counts['/event'], 'event')}, {_several(counts['/link'], 'message')} lost, duplicated or "
        "queued by the link",
        f"{_several(counts['/command'], 'command')}, {_several(counts['/command_stage'], 'command stage')}, "
        f"{_several(counts['/ack'], 'acknowledgement')} and {_several(counts['/telemetry'], 'telemetry frame')}, with "
        "their delivery times",
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
