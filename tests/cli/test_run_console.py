"""`waypointctl run --console` and `--resume` as people and scripts use them."""

from __future__ import annotations

import json
import os
import pty
import re
import signal
import subprocess
import sys
import termios
import threading
import time
from pathlib import Path

import pytest

from tests.cli.flying import Program, start
from tests.forked import ForkedProgram
from waypointctl.log.messages import Command, CommandKind, ConsoleInput
from waypointctl.log.reader import open_log
from waypointctl.replay.verify import Verdict, verify

LIMIT_S = 120.0


def typed(path: Path) -> list[str]:
    return [message.text for message in open_log(path).messages() if isinstance(message, ConsoleInput)]


def fly(yard: Path, *more: str, mission: str = "easy.yaml") -> ForkedProgram:
    arguments = ("run", mission, "--console", "--out", "log.mcap", *more)
    return start(yard, *arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def session(yard: Path, lines: str, *more: str) -> tuple[int, str, str]:
    """Fly with all lines typed beforehand."""
    flight = fly(yard, *more)
    out, err = flight.communicate(lines.encode(), timeout=LIMIT_S)
    return flight.wait(0), out.decode(), err.decode()


def wait_for(flight: ForkedProgram, words: bytes) -> bytes:
    """Read stderr up to a line with these words, and return that line."""
    assert flight.stderr is not None
    limit = threading.Timer(LIMIT_S, flight.kill)  # words that never come end the flight, and the test
    limit.start()
    try:
        while True:
            line = flight.stderr.readline()
            assert line, "the flight has ended"
            if words in line:
                return line
    finally:
        limit.cancel()


def say(flight: ForkedProgram, line: str) -> None:
    assert flight.stdin is not None
    flight.stdin.write(f"{line}\n".encode())
    flight.stdin.flush()


def test_lines_that_were_typed_beforehand_are_sent_at_once_and_the_flight_goes_on_to_its_end(yard: Path) -> None:
    code, out, err = session(yard, "tolerance 2\n\n  goto  0.1 0 \n", "--rate", "1000")
    assert code == 1, "a goto takes the place of the plan"
    assert "failure: command 3 (go_to) replaced the plan: 0 of 2" in out
    assert typed(yard / "log.mcap") == ["tolerance 2", "goto  0.1 0", "quit"]
    assert "command 3 sent: go_to (0.1, 0)" in err
    assert verify(yard / "log.mcap").verdict is Verdict.EXACT


def test_what_is_no_command_is_answered_and_not_sent(yard: Path) -> None:
    wrong = ("fly", "goto 1", "goto a b", "goto nan 1", "goto 1e9 0", "hold on", "cancel 1.5", "release", "x" * 5000)
    code, _, err = session(yard, "\n".join([*wrong, "\x00\x1b[2J", "QUIT", "quit", "hold"]), "--rate", "1000")
    assert code == 0
    assert typed(yard / "log.mcap") == ["quit"]
    assert err.count("not sent: ") == len(wrong) + 2
    assert "not sent: unknown command 'fly'; commands are: goto X m Y m [hold T s]" in err
    assert "not sent: goto takes X m Y m, not '1'" in err
    assert "\x1b" not in err
    assert "Traceback" not in err


def test_status_tells_what_was_heard_and_nothing_else(yard: Path) -> None:
    flight = fly(yard, "--rate", "1")
    say(flight, "status")
    wait_for(flight, b"robot: no telemetry received yet")
    wait_for(flight, b"ack received: command 1 started")
    say(flight, "status")
    robot = wait_for(flight, b"robot, ").decode()
    assert re.search(r": at \(-?0\.0\d, -?0\.0\d\) m, heading ", robot)
    age_s = float(robot.split()[1])
    assert 0.5 <= age_s < 2.0, "as old as the delay at least"
    assert b"started " in wait_for(flight, b"command 1 upload_plan here, there")
    say(flight, "time\nhelp\nquit")
    assert b"at 1 times real time" in wait_for(flight, b"time ")
    wait_for(flight, b"commands: goto X m Y m [hold T s]")
    _, rest = flight.communicate(timeout=LIMIT_S)
    assert flight.returncode == 0, rest
    assert typed(yard / "log.mcap") == ["quit"]


def test_the_console_shows_the_operators_clock_alone(yard: Path) -> None:
    _, _, err = session(yard, "", "--rate", "1000")
    assert "  operator  " in err
    assert "  robot  " not in err


def test_commands_go_over_the_link_while_it_flies(yard: Path) -> None:
    flight = fly(yard, "--rate", "4", mission="long.yaml")
    wait_for(flight, b"ack received: command 1 started")
    say(flight, "hold")
    wait_for(flight, b"ack received: command 2 completed")
    say(flight, "resume")
    wait_for(flight, b"ack received: command 3 completed")
    say(flight, "abort")
    wait_for(flight, b"command 4")
    flight.send_signal(signal.SIGINT)
    with flight:
        assert flight.wait(LIMIT_S) == 130, "before its input ends"
    kinds = [message.kind for message in open_log(yard / "log.mcap").messages() if isinstance(message, Command)]
    assert kinds[:3] == [CommandKind.UPLOAD_PLAN, CommandKind.HOLD, CommandKind.RESUME]
    assert typed(yard / "log.mcap") == ["hold", "resume", "abort"]
    assert verify(yard / "log.mcap").verdict is Verdict.EXACT


@pytest.mark.slow
def test_a_flight_with_a_console_is_held_to_real_time_until_it_closes(yard: Path) -> None:
    flight = fly(yard, mission="long.yaml")
    wait_for(flight, b"ack received: command 1 started")
    time.sleep(1.0)
    say(flight, "time")
    now_s = float(wait_for(flight, b"time ").split()[1])
    assert 0.5 < now_s < 60.0
    say(flight, "quit")
    flight.communicate(timeout=LIMIT_S)
    assert flight.returncode == 0, "an hour's hold, as fast as it goes"


def test_the_answer_stays_one_json_object(yard: Path) -> None:
    code, out, err = session(yard, "status\nquit\n", "--json", "--rate", "1000")
    assert (code, json.loads(out)["outcome"]) == (0, "success")
    assert "robot: no telemetry received yet" in err


def test_without_stdin_there_is_no_console(yard: Path) -> None:
    code = "import sys; sys.stdin = None; from waypointctl.cli.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code, "run", "easy.yaml", "--console"], cwd=yard, capture_output=True, check=False
    )
    assert done.returncode == 2
    assert b"there is no stdin to read commands from" in done.stderr
    assert b"Traceback" not in done.stderr


def test_on_a_terminal_a_line_can_be_edited_and_the_terminal_is_given_back(yard: Path) -> None:
    master, slave = pty.openpty()
    before = termios.tcgetattr(slave)
    arguments = ("run", "easy.yaml", "--console", "--rate", "20", "--out", "log.mcap")
    flight = start(yard, *arguments, stdin=slave, stdout=slave, stderr=slave, TERM="xterm")
    shown = b""

    def see(words: bytes) -> None:
        nonlocal shown
        while words not in shown:
            shown += os.read(master, 4096)

    see(b"> ")
    os.write(master, b"nonsense\x15tolerancee\x7f 2.5\r")
    see(b"command 2 sent: set_tolerance 2.5 m")
    os.write(master, b"\x1b[A\r")
    see(b"command 3 sent: set_tolerance 2.5 m")
    os.write(master, b"\x1b[3~\x04")
    see(b"success: 2 of 2 waypoints reached")
    assert flight.wait(LIMIT_S) == 0
    assert termios.tcgetattr(slave) == before
    os.close(slave)
    assert typed(yard / "log.mcap") == ["tolerance 2.5", "tolerance 2.5", "quit"]


def cut(yard: Path, *more: str) -> tuple[Path, bytes]:
    """Return the .part of a flight that was killed, and the bytes of the log that it was to become."""
    fly_it = start(yard, "run", "easy.yaml", "--out", "log.mcap", *more, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    fly_it.communicate(timeout=LIMIT_S)
    path = yard / "log.mcap"
    data = path.read_bytes()
    part = path.rename(yard / "log.mcap.part")
    part.write_bytes(data[: open_log_end(data, yard)])
    return part, data


def open_log_end(data: bytes, yard: Path) -> int:
    whole = yard / "whole.mcap"
    whole.write_bytes(data)
    offset = open_log(whole).index.chunks[-1].offset
    whole.unlink()
    return offset + 10


def test_a_killed_flight_goes_on(yard: Path, program: Program) -> None:
    part, data = cut(yard)
    code, out, err = program("run", "--resume", str(part), "--json")
    found = json.loads(out)
    assert (code, found["outcome"], found["log"]) == (0, "success", str(yard / "log.mcap"))
    assert (yard / "log.mcap").read_bytes() == data
    assert not part.exists()
    assert re.match(r"easy: repeated up to \d+\.\d\d s from the log; the flight continues from there\n", err)
    assert "mission easy started" not in err, "what was told before is not told again"
    assert "success: 2 of 2 waypoints reached" in err


def test_a_complete_flight_is_said_to_be(yard: Path, program: Program) -> None:
    program("run", "easy.yaml", "--out", "log.mcap", "--json")
    before = (yard / "log.mcap").stat()
    code, out, err = program("run", "--resume", "log.mcap")
    assert (code, out) == (0, "")
    assert err == "log.mcap is complete: success: 2 of 2 waypoints reached in 2.04 s\n"
    code, out, _ = program("run", "--resume", "log.mcap", "--json")
    assert json.loads(out)["waypoints_reached"] == 2
    assert (yard / "log.mcap").stat() == before


@pytest.mark.parametrize(
    "more", [("easy.yaml",), ("--seed", "1"), ("--policy", "still"), ("--out", "other.mcap"), ("--force",)]
)
def test_what_would_make_another_flight_of_it_is_refused(yard: Path, program: Program, more: tuple[str, ...]) -> None:
    code, out, err = program("run", "--resume", "log.mcap", *more)
    assert (code, out) == (2, "")
    assert "cannot be used with --resume" in " ".join(err.split())


def test_a_console_is_not_opened_where_there_was_none(yard: Path, program: Program) -> None:
    part, _ = cut(yard)
    before = part.read_bytes()
    code, _, err = program("run", "--resume", str(part), "--console")
    assert code == 2
    assert "the flight was started without a console" in err
    assert part.read_bytes() == before


def test_a_flight_is_of_something(yard: Path, program: Program) -> None:
    code, _, err = program("run")
    assert code == 2
    assert "name a mission file, or a log with --resume" in err


@pytest.mark.slow
def test_a_resumed_flight_keeps_to_a_rate_from_where_the_log_ends(yard: Path, program: Program) -> None:
    part, data = cut(yard)
    began_s = time.monotonic()
    assert program("run", "--resume", str(part), "--rate", "0.05")[0] == 0
    # 40 ms are left to be flown, for 0.8 s; all of it would take 40 s.
    assert 0.7 <= time.monotonic() - began_s < 40.0
    assert (yard / "log.mcap").read_bytes() == data
