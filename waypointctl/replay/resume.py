"""Continuing a killed flight: it is simulated again to the end of its log, and flown from there.

The first part is a replay, every message compared with the log's, bit for bit. A flight is the same every time, so what
follows is what would have followed, and the finished log is that of a flight that nobody killed, byte for byte.

No moment of it can lose anything. The flight is written into a log of its own, `<name>.resumed.part`; once that has
all that the old one has, it takes the old one's place, and at the end the name `<name>`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from waypointctl.errors import InputError, LogError, OutputError
from waypointctl.flight.fly import fly
from waypointctl.flight.operator.console import QUIT, LineSource
from waypointctl.flight.outcome import FlightResult
from waypointctl.flight.policy_fit import PolicyNotInLog
from waypointctl.flight.sink import Camera, Sink, with_pictures
from waypointctl.log.comparison import Diverged, Divergence
from waypointctl.log.messages import Event, Message, Picture, State
from waypointctl.log.opening import PART, open_file
from waypointctl.log.reader import LogReader, open_log
from waypointctl.log.writer import LogWriter
from waypointctl.paths import lock
from waypointctl.replay.comparator import LogComparator
from waypointctl.replay.contents import LogContents, contents_of, platform_differences, unverifiable
from waypointctl.replay.recorded import RecordedCamera, RecordedConsole, RecordedPolicy
from waypointctl.replay.summary import FlightSummary
from waypointctl.replay.summary_builder import summary_of_events
from waypointctl.task.plugins import Plugin

_KEPT: Final = (
    "The log is unchanged; `waypointctl info` shows its contents. `waypointctl run` flies the mission from the start."
)


@dataclass(frozen=True, slots=True)
class Unfinished:
    """A flight that was killed."""

    log: LogReader  # what is left of it
    path: Path  # of the finished log
    contents: LogContents  # what flies it
    events: FlightSummary  # the summary of its events


class Interrupted(Exception):
    """The flight was interrupted before the end of the old log, which is unchanged."""


@contextmanager
def unfinished(path: Path, plugins: Sequence[Plugin] = ()) -> Iterator[Unfinished | None]:
    """Yield the flight of a log, locked against other processes; None if the flight has ended.

    Args:
        path: of the log: its .part, or the name that it was to have.
        plugins: observation groups and reward terms that it was flown with and that are not built in.

    Raises:
        LogError: it cannot be read, carries nothing that can be flown, is altered, or is being written.
    """
    final = path.with_name(path.name.removesuffix(PART))
    part = final.with_name(f"{final.name}{PART}")
    found = part if part.exists() else final
    with open_file(found) as stream:
        if not lock(stream):
            raise LogError("is being written by a running flight", where=str(found), hint="Wait for its end.")
        log = open_log(found, allow_truncated=True)
        events = summary_of_events(log)
        if log.is_complete and events.has_end:
            if found == part:
                part.replace(final)  # it was killed when all was written, just before this
            yield None
            return
        yield Unfinished(log, final, _contents(log, plugins), events)


def go_on(
    flight: Unfinished,
    *,
    again: Sink,
    watch: Sink,
    interrupted: Callable[[], bool] = lambda: False,
    console: LineSource | None = None,
) -> FlightResult:
    """Simulate a flight to the end of its log, and fly it from there.

    Args:
        flight: which.
        again: sees every message of the first part.
        watch: sees every message of the second part, as it happens.
        interrupted: called before every control step; True ends the flight and closes the log.
        console: where a person's commands come from in the second part; without it a console that is open is closed.

    Raises:
        Interrupted: in the first part.
        LogError: the flight is not the same again, or the log is damaged.
        OutputError: the log cannot be written.
    """
    contents = flight.contents
    beside = flight.path.with_name(f"{flight.path.name}.resumed{PART}")
    comparator = LogComparator(flight.log.encoded_messages(), bitwise=True)
    by_hand = RecordedConsole(comparator, contents.mission, flight.events)
    lines = _Lines(by_hand, comparator, console)

    def stopped() -> bool:
        if by_hand.interrupted():
            return True  # it was killed while its interrupted log was being closed
        if interrupted() and not comparator.has_ended:
            raise Interrupted
        return interrupted()

    try:
        with contents.camera as camera, LogWriter(flight.path, contents.header(), part=beside) as writer:
            audited = RecordedCamera(camera, comparator)
            sink = with_pictures(_passage(comparator, writer, again, watch), _camera(comparator, audited, camera))
            policy = RecordedPolicy(contents.policy, comparator, bitwise=True)
            robot, plugins = contents.robot, contents.plugins
            result = fly(
                contents.mission, policy, sink, robot=robot, interrupted=stopped, console=lines, plugins=plugins
            )
            _require_all_seen(comparator, result)
    except Diverged as error:
        raise _not_the_same(flight.log, error.where) from None
    except OutputError as error:
        if not beside.exists():  # it has taken the old one's place, and has all that the old one had
            raise
        hint = f"Make room on the disk and resume it again: {flight.log.path} is unchanged."
        raise OutputError(error.problem, where=error.where, hint=hint) from error
    finally:
        beside.unlink(missing_ok=True)  # after an error in the first part; later it has its place
    taken = audited.handed_on + camera.taken
    return replace(result, pictures=taken, no_pictures=camera.trouble).logged(flight.path)


def _camera(comparator: LogComparator, again: Camera, anew: Camera) -> Camera:
    """Return a camera that takes the old log's pictures as long as that lasts, and then its own."""

    def take(event: Event, state: State) -> Picture | None:
        return (anew if comparator.has_ended else again)(event, state)

    return take


def _passage(comparator: LogComparator, writer: LogWriter, again: Sink, watch: Sink) -> Sink:
    """Return a sink that leads from the old log to the new one."""

    def take(message: Message) -> None:
        is_new = comparator.has_ended
        if not is_new:
            comparator(message)
        (watch if is_new else again)(message)
        flushes = writer.flushes
        writer(message)
        if is_new and writer.flushes > flushes:
            writer.take_place()  # all that came before this message is in the file

    return take


class _Lines:
    """The console: what the log has of it, then a person, or the end of it."""

    def __init__(self, logged: RecordedConsole, comparator: LogComparator, person: LineSource | None) -> None:
        self.is_open = logged.is_open
        self._logged = logged
        self._comparator = comparator
        self._person = person

    def lines(self, now_ns: int) -> Iterator[str]:
        yield from self._logged.lines(now_ns)
        if not self._comparator.has_ended or not self._is_listening:
            return
        if self._person is not None:
            yield from self._person.lines(now_ns)
        else:
            self._logged.has_closed = True
            yield QUIT

    def asleep(self, now_ns: int, until_ns: int) -> int:
        woken_ns = self._logged.asleep(now_ns, until_ns)
        if not self._comparator.has_ended or self._person is None or not self._is_listening:
            return woken_ns
        return self._person.asleep(now_ns, woken_ns)

    @property
    def _is_listening(self) -> bool:
        return self.is_open and not self._logged.has_closed


def _contents(log: LogReader, plugins: Sequence[Plugin]) -> LogContents:
    where = str(log.path)
    if reason := unverifiable(log):
        raise LogError(f"cannot be resumed: {reason}", where=where, hint=_KEPT)
    try:
        contents = contents_of(log, plugins)
    except InputError as error:
        problem = f"cannot be resumed: its contents cannot be used: {error.problem}"
        hint = f"{error.hint}. {_KEPT}" if error.hint else _KEPT
        raise LogError(problem, where=where, hint=hint, details=error.details) from error
    if isinstance(contents, Divergence):
        problem = f"cannot be resumed: {contents.component} differs from its recorded hash"
        raise LogError(problem, where=where, hint=_KEPT)
    if isinstance(contents.policy, PolicyNotInLog):
        problem = f"cannot be resumed: the policy, {contents.policy.class_name}, is not in the log"
        raise LogError(problem, where=where, hint=_KEPT)
    return contents


def _require_all_seen(comparator: LogComparator, result: FlightResult) -> None:
    if comparator.upcoming is not None:
        raise comparator.diverged(
            "/event", "end", type(comparator.upcoming).__name__, f"the flight has ended: {result.reason}"
        )


def _not_the_same(log: LogReader, where: Divergence) -> LogError:
    """Return the error for a flight that diverges from its log."""
    problem = (
        f"cannot be resumed: the simulation diverges from it at step {where.step} on {where.topic}, "
        f"{where.component}: logged {where.logged}, now {where.replayed}"
    )
    others = platform_differences(log)
    why = (
        f"It was made elsewhere ({', '.join(others)}), where it can be resumed. " if others else "It has been altered. "
    )
    return LogError(problem, where=str(log.path), hint=f"{why}{_KEPT}")
