"""The proof of replay: the flight is flown again from the log and nothing else, and compared bit for bit."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from waypointctl.errors import InputError
from waypointctl.flight.fly import fly
from waypointctl.flight.header import platform_facts
from waypointctl.flight.sink import with_pictures
from waypointctl.log.messages import Message
from waypointctl.log.reader import LogReader, open_log
from waypointctl.replay.comparator import Diverged, LogComparator, LogEnded, RecordedPolicy
from waypointctl.replay.compared import Compared
from waypointctl.replay.contents import KERNELS, LogContents, altered, contents_of, platform_differences, unverifiable
from waypointctl.replay.flight_log import summary_of_events
from waypointctl.replay.recorded_camera import RecordedCamera
from waypointctl.replay.recorded_console import RecordedConsole
from waypointctl.replay.verdict import Divergence, Verdict, Verification
from waypointctl.replay.whole_file import whole_file


def verify(path: Path | str) -> Verification:
    """Simulate the flight of a log again, from the log alone, and compare every message and byte.

    Raises:
        LogError: the log cannot be read.
    """
    return verify_log(open_log(Path(path)))


def verify_log(log: LogReader) -> Verification:
    """Fly the flight of a log again and compare the whole log.

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
        if wrong := altered(log):
            reason = f"diverged before the flight: {wrong.component} is not what was recorded"
            return Verification(Verdict.DIVERGED, 0, wrong, reason, ())
        contents = contents_of(log)
    except InputError as error:
        return Verification(Verdict.UNVERIFIABLE, 0, None, f"what the log carries cannot be used: {error}", ())
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
            )
            if comparator.upcoming is not None:
                raise comparator.diverged("/event", "end", type(comparator.upcoming).__name__, "the flight is over")
            whole.finish()
            compared = Compared.of(contents, comparator, policy, pictures, whole)
    except Diverged as error:
        if error.rounding and other_kernels:
            reason = f"rounded otherwise at step {error.where.step} on {error.where.topic}: {', '.join(other_kernels)}"
            return Verification(Verdict.UNVERIFIABLE, comparator.compared["/reward"], error.where, reason, ())
        return _diverged(error.where, comparator, log)
    except LogEnded:
        ended = comparator.diverged("/event", "end", "the log ends", "the flight goes on")
        return _diverged(ended.where, comparator, log)
    return compared.verification(comparator.compared["/action"])


def _diverged(where: Divergence, comparator: LogComparator, log: LogReader) -> Verification:
    reason = f"diverged {where.place}"
    wrote, here = _software(log.metadata), _software(platform_facts())
    if wrote != here:
        reason += (
            f" (waypointctl {wrote} wrote the log, this is {here}: another program, not an altered log, may be why)"
        )
    return Verification(Verdict.DIVERGED, comparator.compared["/reward"], where, reason, ())


def _software(facts: Mapping[str, str]) -> str:
    return f"{facts.get('version_waypointctl')} ({facts.get('source')})"
