"""Signals: the first asks a flight to end, the second ends the program, whatever it is doing."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.cli.flying import Program, start
from waypointctl.cli.program import Ending, ending, interruption
from waypointctl.log.reader import open_log

SIGNALS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
LIMIT_S = 60.0


@pytest.fixture(autouse=True)
def clock(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[float]]:
    """The time that signals are told apart by; its last entry is now [s]."""
    now_s = [0.0]
    monkeypatch.setattr("waypointctl.cli.program.monotonic", lambda: now_s[-1])
    yield now_s
    Ending.is_forced = False


@pytest.mark.parametrize("number", SIGNALS)
def test_the_first_signal_asks_and_the_second_ends(number: signal.Signals, clock: list[float]) -> None:
    with interruption() as interrupted:
        assert not interrupted()
        os.kill(os.getpid(), number)
        assert interrupted()
        clock.append(1.0)
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), number)


def test_signals_of_one_press_are_one(clock: list[float]) -> None:
    with interruption() as interrupted:
        for now_s in (0.0, 0.05, 0.19):
            clock.append(now_s)
            os.kill(os.getpid(), signal.SIGINT)
        assert interrupted()


def test_signals_mean_afterwards_what_they_meant_before() -> None:
    before = [signal.getsignal(number) for number in SIGNALS]
    with interruption():
        assert all(signal.getsignal(number) not in before for number in SIGNALS)
    assert [signal.getsignal(number) for number in SIGNALS] == before


def test_a_signal_that_is_ignored_stays_ignored() -> None:
    signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup starts a program
    with interruption() as interrupted:
        os.kill(os.getpid(), signal.SIGHUP)
        assert not interrupted()


def test_what_an_interruption_breaks_on_its_way_is_exit_code_130(
    program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Modules that are being imported turn it into errors of their own."""

    def broken(*arguments: object) -> None:
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt as error:
            raise ImportError("multiarray failed to import") from error

    monkeypatch.setattr("waypointctl.cli.validate._refuse_missing", broken)
    assert program("validate", "mission.yaml") == (130, "", "")


def test_a_bug_is_not_taken_for_an_interruption() -> None:
    with pytest.raises(ImportError), ending():
        raise ImportError


@pytest.mark.parametrize("presses", [1, 2])
def test_ctrl_c_while_the_program_loads_its_modules(yard: Path, presses: int) -> None:
    code = (
        "import os, signal, sys\n"
        "from waypointctl.cli.main import main\n"
        "class Slow:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name == 'waypointctl.cli.app':\n"
        f"            for _ in range({presses}): os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Slow())\n"
        "sys.argv = ['waypointctl', '--help']\n"
        "main()\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=yard, capture_output=True, timeout=LIMIT_S, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, b"", b"")


@pytest.mark.slow
def test_a_terminal_that_is_closed_ends_a_flight_with_its_log_whole(yard: Path) -> None:
    master, slave = pty.openpty()
    flight = start(
        yard, "run", "long.yaml", "--rate", "1", "--out", "log.mcap", stdin=slave, stdout=slave, stderr=slave
    )
    os.close(slave)
    shown = b""
    while b"holding at rest" not in shown:
        shown += os.read(master, 4096)
    os.close(master)
    flight.send_signal(signal.SIGHUP)
    assert flight.wait(LIMIT_S) == 130
    assert open_log(yard / "log.mcap").is_complete


@pytest.mark.slow
def test_flying_and_replaying_put_nothing_into_the_folder_for_temporary_files(yard: Path) -> None:
    """So that nothing is left there by a program that is killed."""
    (yard / "temporary").mkdir()
    for arguments in (("run", "easy.yaml", "--out", "log.mcap"), ("replay", "log.mcap", "--png", "log.png")):
        done = start(yard, *arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, TMPDIR="temporary")
        _, err = done.communicate(timeout=LIMIT_S)
        assert (done.returncode, list((yard / "temporary").iterdir())) == (0, []), err
