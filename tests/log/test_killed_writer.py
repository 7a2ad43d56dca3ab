"""A flight whose process is killed loses less than a simulated second."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader

from tests.log.fake_flight import bits, flight
from waypointctl.errors import LogError
from waypointctl.log.messages import Message
from waypointctl.log.reader import open_log
from waypointctl.log.topics import BY_KIND
from waypointctl.units import NS_PER_S

ROOT = Path(__file__).parents[2]


def time_ns(message: Message) -> int:
    return BY_KIND[type(message)].times_ns(message)[0]


@pytest.fixture(scope="module", params=[0, 3, 350, 700], ids=lambda count: f"after {count}")
def killed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Message]]:
    """The .part of a flight that was killed after so many messages, and those messages."""
    folder = tmp_path_factory.mktemp("killed")
    command = [sys.executable, "-m", "tests.log.fake_flight", str(folder / "flight.mcap")]
    process = subprocess.run([*command, "--die-after", str(request.param)], cwd=ROOT, check=False)
    assert process.returncode == -signal.SIGKILL
    assert [it.name for it in folder.iterdir()] == ["flight.mcap.part"]
    return folder / "flight.mcap.part", list(flight())[: request.param]


def test_less_than_a_simulated_second_is_lost(killed: tuple[Path, list[Message]]) -> None:
    path, written = killed
    log = open_log(path, allow_truncated=True)
    kept = list(log.messages())
    assert not log.is_complete
    assert set(log.attachments) == {"mission.yaml", "model.mjb", "foxglove-layout.json"}
    assert [bits(message) for message in kept] == [bits(message) for message in written[: len(kept)]]
    lost = [time_ns(message) for message in written[len(kept) :]]
    assert not lost or max(lost) - min(lost) < NS_PER_S


def test_it_is_not_read_unasked(killed: tuple[Path, list[Message]]) -> None:
    with pytest.raises(
        LogError, match=r"is cut short at byte \d+, its messages reach to \d\.\d+ s: its writer was killed"
    ):
        open_log(killed[0])


def test_standard_reader_reads_it_to_where_it_ends(killed: tuple[Path, list[Message]]) -> None:
    path, _ = killed
    read = 0
    with open(path, "rb") as stream, pytest.raises(EndOfFile):  # noqa: PT012
        for _ in NonSeekingReader(stream, validate_crcs=True).iter_messages(log_time_order=False):
            read += 1
    assert read == open_log(path, allow_truncated=True).message_count
