from __future__ import annotations

import os
import pty
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.cli.flying import start
from tests.forked import ForkedProgram
from waypointctl.log.messages import Event, EventKind
from waypointctl.replay.flight_log import FlightLog

LIMIT_S = 60.0


def fly(yard: Path, *more: str, stdout: int = subprocess.PIPE) -> ForkedProgram:
    """Start a long flight and return when the robot has begun to hold."""
    arguments = ("run", "long.yaml", "--out", "log.mcap", *more)
    flight = start(yard, *arguments, stdout=stdout, stderr=subprocess.PIPE)
    assert flight.stderr is not None
    while b"holding at rest" not in flight.stderr.readline():
        assert flight.poll() is None
    return flight


@pytest.mark.parametrize(
    ("number", "more"),
    [(signal.SIGINT, ("--rate", "1")), (signal.SIGTERM, ()), (signal.SIGINT, ("--rate", "0.001"))],
)
def test_the_first_signal_closes_the_log(yard: Path, number: signal.Signals, more: tuple[str, ...]) -> None:
    flight = fly(yard, *more)
    flight.send_signal(number)
    out, _ = flight.communicate(timeout=LIMIT_S)
    assert flight.returncode == 130
    log = FlightLog.open(yard / "log.mcap")
    assert log.is_complete
    *_, last = log.messages()
    assert isinstance(last, Event)
    assert (last.kind, last.text.partition(":")[0]) == (EventKind.MISSION_ENDED, "interrupted")
    assert log.summary.outcome == "interrupted"
    assert b"interrupted: 1 of 1 waypoints known to be reached" in out
    assert not (yard / "log.mcap.part").exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_an_interrupted_flight_is_one_also_where_its_answer_cannot_be_written(yard: Path) -> None:
    with Path("/dev/full").open("wb") as full:
        flight = fly(yard, "--rate", "1", stdout=full.fileno())
    flight.send_signal(signal.SIGINT)
    _, said = flight.communicate(timeout=LIMIT_S)
    assert flight.returncode == 130
    assert b"error: the answer cannot be written" in said


def test_a_mission_that_never_comes_does_not_keep_the_program(yard: Path) -> None:
    os.mkfifo(yard / "pipe.yaml")
    refused = start(yard, "run", "pipe.yaml", stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    _, said = refused.communicate(timeout=LIMIT_S)
    assert refused.returncode == 2
    assert (
        said
        == b"error: pipe.yaml: is a named pipe, not a file\n  Write what comes out of it into a file, and give that\n"
    )
    assert not (yard / "logs").exists()


def test_a_flight_that_is_killed_leaves_what_it_had(yard: Path) -> None:
    flight = fly(yard, "--rate", "4")
    time.sleep(1.0)
    flight.kill()
    flight.communicate(timeout=LIMIT_S)
    assert not (yard / "log.mcap").exists()
    log = FlightLog.open(yard / "log.mcap.part", allow_truncated=True)
    assert log.summary.outcome == "unfinished"
    assert log.summary.steps > 0


def test_interrupted_on_a_terminal_it_gives_the_cursor_back(yard: Path) -> None:
    master, slave = pty.openpty()
    flight = start(yard, "run", "long.yaml", "--rate", "1", stdin=slave, stdout=slave, stderr=slave)
    os.close(slave)
    shown = b""
    while b"holding at rest" not in shown:
        shown += os.read(master, 4096)
    flight.send_signal(signal.SIGINT)
    while True:
        try:
            chunk = os.read(master, 4096)
        except OSError:  # the other end is closed
            break
        shown += chunk
    assert flight.wait(LIMIT_S) == 130
    assert shown.rindex(b"\x1b[?25h") > shown.rindex(b"\x1b[?25l")
    assert b"interrupted" in shown
