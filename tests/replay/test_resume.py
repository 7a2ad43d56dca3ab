"""A flight whose process was killed, as its log shows it: cut short anywhere. It goes on as if nothing had been."""

from __future__ import annotations

import errno
import os
import random
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.flight.scripted_lines import ScriptedLines
from tests.log.fake_flight import bits
from tests.replay.rewriting import Flown, altered
from tests.replay.test_verify_console import LINES, session
from waypointctl.errors import LogError, OutputError
from waypointctl.flight.sink import Sink
from waypointctl.log.channels import ChannelWriter
from waypointctl.log.messages import ConsoleInput, Message, State
from waypointctl.log.reader import open_log
from waypointctl.paths import lock
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.resume import Interrupted, go_on, unfinished
from waypointctl.replay.verify import Verdict, verify

CUTS = 5


@dataclass(frozen=True)
class Whole:
    """A flight that nobody killed."""

    path: Path
    data: bytes
    messages: list[Message]

    @property
    def begin(self) -> int:
        """Where its first message stands; before that a log is none."""
        return open_log(self.path).index.chunks[0].offset

    def cut(self, folder: Path, size: int) -> Path:
        """Return the .part of a flight that was killed when it had written so many bytes."""
        part = folder / "flight.mcap.part"
        part.write_bytes(self.data[:size])
        return part

    def cut_at(self, folder: Path, time_s: float) -> Path:
        """Return the .part of a flight that was killed at about this time."""
        chunks = open_log(self.path).index.chunks
        return self.cut(folder, next(chunk.offset for chunk in chunks if chunk.first_ns >= time_s * 1e9))


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Whole:
    """A session at the console, without and with physics asleep."""
    folder = tmp_path_factory.mktemp("whole")
    flown = session(folder, make_policy(folder / "policy", gain=0.0), *LINES)
    return Whole(flown.path, flown.path.read_bytes(), flown.messages)


def nothing(message: Message) -> None:
    pass


def attempted(
    path: Path,
    *later: tuple[float, str],
    again: Sink = nothing,
    watch: Sink = nothing,
    interrupted: Callable[[], bool] = lambda: False,
) -> None:
    """Go on with a flight in a way that does not come to its end."""
    with unfinished(path) as flight:
        assert flight is not None
        go_on(flight, again=again, watch=watch, interrupted=interrupted, console=ScriptedLines(*later))


def resumed(path: Path, *later: tuple[float, str]) -> tuple[list[Message], list[Message]]:
    """Go on with a flight; return what was flown again and what was new."""
    again: list[Message] = []
    new: list[Message] = []
    with unfinished(path) as flight:
        assert flight is not None
        go_on(flight, again=again.append, watch=new.append, console=ScriptedLines(*later))
    return again, new


@pytest.mark.parametrize("number", range(CUTS))
def test_wherever_it_was_cut_the_finished_log_is_the_same_bytes(whole: Whole, tmp_path: Path, number: int) -> None:
    share = (number + random.Random(number).random()) / CUTS
    part = whole.cut(tmp_path, round(whole.begin + share * (len(whole.data) - whole.begin)))
    kept = list(open_log(part, allow_truncated=True).messages())
    typed = sum(isinstance(message, ConsoleInput) for message in kept)
    again, new = resumed(part, *LINES[typed:])
    assert (tmp_path / "flight.mcap").read_bytes() == whole.data
    assert [bits(message) for message in again] == [bits(message) for message in kept]
    assert [bits(message) for message in again + new] == [bits(message) for message in whole.messages]
    assert [path.name for path in tmp_path.iterdir()] == ["flight.mcap"]


def test_it_may_be_named_as_it_was_to_be_named(whole: Whole, tmp_path: Path) -> None:
    whole.cut_at(tmp_path, 1.0)
    resumed(tmp_path / "flight.mcap", *LINES[1:])
    assert (tmp_path / "flight.mcap").read_bytes() == whole.data


def test_a_killed_flight_that_was_to_replace_a_log_still_does(whole: Whole, tmp_path: Path) -> None:
    (tmp_path / "flight.mcap").write_bytes(b"an older flight")
    whole.cut_at(tmp_path, 1.0)
    resumed(tmp_path / "flight.mcap", *LINES[1:])
    assert (tmp_path / "flight.mcap").read_bytes() == whole.data


def test_without_a_console_the_one_that_was_open_is_closed(whole: Whole, tmp_path: Path) -> None:
    part = whole.cut_at(tmp_path, 3.0)
    with unfinished(part) as flight:
        assert flight is not None
        go_on(flight, again=nothing, watch=nothing)
    typed = [m.text for m in open_log(tmp_path / "flight.mcap").messages() if isinstance(m, ConsoleInput)]
    assert typed == [*(text for at_s, text in LINES if at_s < 3.0), "quit"]
    assert verify(tmp_path / "flight.mcap").verdict is Verdict.EXACT


def test_a_log_with_its_end_is_complete(whole: Whole, tmp_path: Path) -> None:
    path = tmp_path / "flight.mcap"
    path.write_bytes(whole.data)
    with unfinished(path) as flight:
        assert flight is None
    assert path.read_bytes() == whole.data


def test_a_flight_killed_before_its_log_had_its_name_gives_it_that(whole: Whole, tmp_path: Path) -> None:
    part = whole.cut(tmp_path, len(whole.data))
    with unfinished(part) as flight:
        assert flight is None
    assert not part.exists()
    assert (tmp_path / "flight.mcap").read_bytes() == whole.data


class Killed(Exception):
    """Stands for the end of the process."""


def test_once_it_has_all_that_was_there_its_own_log_takes_the_place(whole: Whole, tmp_path: Path) -> None:
    part = whole.cut_at(tmp_path, 1.0)
    before = part.read_bytes()
    sizes = []

    def watch(message: Message) -> None:
        if isinstance(message, State):
            sizes.append(part.stat().st_size)
            if message.time_ns >= 4_000_000_000:
                raise Killed

    with pytest.raises(Killed):
        attempted(part, *LINES[1:], watch=watch)
    assert sizes == sorted(sizes), "at no time is there less than there was"
    assert part.read_bytes()[: len(before)] == before
    assert len(list(open_log(part).messages(("/state",)))) > 150
    assert [path.name for path in tmp_path.iterdir()] == [part.name]
    resumed(part, *LINES[4:])
    assert (tmp_path / "flight.mcap").read_bytes() == whole.data


def test_an_error_on_the_way_to_where_it_was_leaves_the_log_alone(whole: Whole, tmp_path: Path) -> None:
    part = whole.cut_at(tmp_path, 3.0)
    before = part.read_bytes()

    def again(message: Message) -> None:
        if isinstance(message, State) and message.time_ns >= 2_000_000_000:
            raise Killed

    with pytest.raises(Killed):
        attempted(part, again=again)
    assert part.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == [part.name]


def test_interrupted_on_the_way_to_where_it_was_it_leaves_the_log_alone(whole: Whole, tmp_path: Path) -> None:
    part = whole.cut_at(tmp_path, 3.0)
    before = part.read_bytes()
    with pytest.raises(Interrupted):
        attempted(part, interrupted=lambda: True)
    assert part.read_bytes() == before


def test_interrupted_later_it_closes_the_log_as_interrupted(whole: Whole, tmp_path: Path) -> None:
    part = whole.cut_at(tmp_path, 3.0)
    new: list[Message] = []
    with unfinished(part) as flight:
        assert flight is not None
        result = go_on(flight, again=nothing, watch=new.append, interrupted=lambda: len(new) > 50)
    assert result.outcome == "interrupted"
    assert verify(tmp_path / "flight.mcap").verdict is Verdict.EXACT


def test_a_flight_that_is_another_one_when_flown_again_is_refused(
    whole: Whole, tmp_path: Path, make_policy: Callable[..., LoadedPolicy]
) -> None:
    flown = session(tmp_path, make_policy(tmp_path / "policy", gain=0.0), *LINES)
    messages = flown.messages
    at = [index for index, message in enumerate(messages) if isinstance(message, State)][40]
    messages[at] = altered(messages[at], "qpos", 7)
    path = flown.rewritten(tmp_path / "other.mcap", messages)
    part = path.rename(tmp_path / "other.mcap.part")
    part.write_bytes(part.read_bytes()[:-5])
    before = part.read_bytes()
    with pytest.raises(LogError, match=r"at step 40 on /state, qpos\[7\]: logged .*\n.* altered.*log is unchanged"):
        resumed(part)
    assert part.read_bytes() == before
    assert not list(tmp_path.glob("*resumed*"))


@pytest.mark.parametrize("where", ["chunk", "attachment"])
def test_a_log_that_is_damaged_is_refused(whole: Whole, tmp_path: Path, where: str) -> None:
    part = whole.cut_at(tmp_path, 3.0)
    data = bytearray(part.read_bytes())
    data[whole.begin + 500 if where == "chunk" else whole.begin // 2] ^= 1
    part.write_bytes(data)
    with pytest.raises(LogError, match="damaged"):
        resumed(part)
    assert part.read_bytes() == bytes(data)


@pytest.mark.parametrize("size", [0, 5, 8, 1000])
def test_of_a_flight_killed_before_it_began_it_is_said_to_run_it_again(whole: Whole, tmp_path: Path, size: int) -> None:
    part = whole.cut(tmp_path, size)
    again = f"`waypointctl run MISSION.yaml --out {part.with_suffix('')} --force`"
    said = rf"flight\.mcap\.part: has no messages: .*\n.*{re.escape(again)}"
    with pytest.raises(LogError, match=said):
        resumed(part)
    for truncated in (True, False):
        with pytest.raises(LogError, match=said):
            open_log(part, allow_truncated=truncated)
    copy = part.rename(tmp_path / "copy.mcap")
    with pytest.raises(LogError, match=r"empty|cut short|not an MCAP"):
        open_log(copy, allow_truncated=True)


def test_a_flight_killed_just_before_its_first_message_is_flown(flown: Flown, tmp_path: Path) -> None:
    data = flown.path.read_bytes()
    (tmp_path / "flight.mcap.part").write_bytes(data[: open_log(flown.path).index.chunks[0].offset])
    resumed(tmp_path / "flight.mcap.part")
    assert (tmp_path / "flight.mcap").read_bytes() == data


def test_a_log_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no such log"):
        resumed(tmp_path / "nowhere.mcap")


def full_from(flush: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the disk be full from a flush of a log on."""
    number = 0
    own = ChannelWriter.flush

    def flushed(writer: ChannelWriter) -> None:
        nonlocal number
        number += 1
        if number >= flush:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        own(writer)

    monkeypatch.setattr(ChannelWriter, "flush", flushed)


@pytest.mark.parametrize("flush", [1, 2, 3])
def test_on_a_full_disk_only_files_that_are_there_are_named(
    whole: Whole, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, flush: int
) -> None:
    part = whole.cut_at(tmp_path, 1.0)
    with monkeypatch.context() as patched:
        full_from(flush, patched)
        with pytest.raises(OutputError, match="No space left") as caught:
            resumed(part, *LINES[1:])
    assert [path.name for path in tmp_path.iterdir()] == ["flight.mcap.part"]
    assert str(part) in str(caught.value)
    assert "resumed.part" not in str(caught.value)
    kept = open_log(part, allow_truncated=True).messages()
    resumed(part, *LINES[sum(isinstance(message, ConsoleInput) for message in kept) :])
    assert (tmp_path / "flight.mcap").read_bytes() == whole.data


def test_nobody_goes_on_with_a_flight_that_is_under_way(whole: Whole, tmp_path: Path) -> None:
    part = whole.cut_at(tmp_path, 1.0)
    with part.open("rb") as writer:
        assert lock(writer)
        with pytest.raises(LogError, match="is being written"):
            resumed(part)
    resumed(part, *LINES[1:])
