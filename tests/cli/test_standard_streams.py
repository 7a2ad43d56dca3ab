"""Standard output and error that are closed, full, read by nobody or not UTF-8: no failure of what a command does."""

from __future__ import annotations

import io
import os
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.flying import Program, start
from waypointctl.cli.console import DisplayStream

PROGRAM = [sys.executable, "-c", "from waypointctl.cli.main import main; main()"]
COMMANDS = [("run", "easy.yaml", "--json"), ("replay", "easy.mcap"), ("validate", "easy.yaml")]


@pytest.fixture
def flown(yard: Path, program: Program) -> Path:
    """The folder with a log in it."""
    assert program("run", "easy.yaml", "--out", "easy.mcap")[0] == 0
    return yard


def encoded(encoding: str) -> tuple[DisplayStream, io.BytesIO]:
    raw = io.BytesIO()
    return DisplayStream(io.TextIOWrapper(raw, encoding=encoding, write_through=True)), raw


@pytest.mark.parametrize(
    ("encoding", "plain", "styled"), [("ascii", rb"caf\xe9", b"caf?"), ("latin-1", b"caf\xe9", b"caf\xe9")]
)
def test_what_an_encoding_lacks_is_escaped_or_as_wide(encoding: str, plain: bytes, styled: bytes) -> None:
    stream, raw = encoded(encoding)
    assert stream.write("café") == 4
    assert raw.getvalue() == plain
    stream.styled.write("\x1b[1mcafé")
    assert raw.getvalue() == plain + b"\x1b[1m" + styled


def test_lines_are_kept_and_nothing_else_that_steers() -> None:
    stream, raw = encoded("utf-8")
    stream.write("a\x1b[2J\n\tb\r\n")
    assert raw.getvalue() == rb"a\u001b[2J" b"\n" rb"\tb\r" b"\n"


class Full(io.StringIO):
    def write(self, text: str) -> int:
        raise OSError(28, "No space left on device")


def test_a_failure_is_kept_and_not_raised() -> None:
    stream = DisplayStream(Full())
    assert stream.write("x") == 1
    stream.flush()
    assert stream.failure is not None
    assert DisplayStream(None).write("x") == 1


@pytest.mark.parametrize(("arguments", "closed"), [(COMMANDS[1], ">&-"), (COMMANDS[0], ">&- 2>&- <&-")])
def test_an_answer_to_a_closed_stream_is_an_error(flown: Path, arguments: tuple[str, ...], closed: str) -> None:
    command = f"{shlex.join([*PROGRAM, *arguments])} {closed}"
    done = subprocess.run(["bash", "-c", command], cwd=flown, capture_output=True, timeout=60, check=False)
    assert done.returncode == 2  # it is done, but its answer is nowhere
    assert b"Traceback" not in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("arguments", COMMANDS[1:2], ids=" ".join)
def test_a_stream_that_is_not_utf8_is_no_failure(flown: Path, arguments: tuple[str, ...]) -> None:
    (flown / "easy.yaml").write_text((flown / "easy.yaml").read_text().replace("name: here", "name: 近い"))
    told = start(
        flown, *arguments, stdout=subprocess.PIPE, stderr=subprocess.PIPE, PYTHONIOENCODING="ascii", LC_ALL="C"
    )
    out, err = told.communicate(timeout=60)
    assert told.returncode == 0
    assert (out + err).isascii()
    assert b"Traceback" not in err


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
@pytest.mark.parametrize("arguments", [COMMANDS[0], ("validate", "nowhere.yaml")], ids=" ".join)
def test_readers_that_go_away_change_nothing(flown: Path, arguments: tuple[str, ...], stream: str) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    out_to, err_to = (writing, subprocess.PIPE) if stream == "stdout" else (subprocess.PIPE, writing)
    told = start(flown, *arguments, stdout=out_to, stderr=err_to)
    os.close(writing)
    out, err = told.communicate(timeout=60)
    assert told.returncode == (2 if "nowhere.yaml" in arguments else 0)
    assert b"Traceback" not in (out or b"") + (err or b"")


def test_what_was_asked_for_is_written_though_nobody_reads_on(flown: Path) -> None:
    command = shlex.join([*PROGRAM, "replay", "easy.mcap", "--png", "easy.png"])
    piped = f"set -o pipefail; {command} | head -n 1"
    done = subprocess.run(["bash", "-c", piped], cwd=flown, capture_output=True, timeout=60, check=False)
    assert done.returncode == 0
    assert done.stdout.startswith(b"EXACT")
    assert (flown / "easy.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_under_stderr_is_no_failure(yard: Path) -> None:
    with Path("/dev/full").open("wb") as full:
        told = start(yard, "run", "easy.yaml", stdout=subprocess.PIPE, stderr=full.fileno())
        out, _ = told.communicate(timeout=60)
    assert told.returncode == 0
    assert out


def test_a_playback_that_nobody_watches_ends(flown: Path) -> None:
    command = shlex.join([*PROGRAM, "replay", "easy.mcap", "--rate", "1000", "--loop"])
    piped = f"{command} 2>&1 | head -n 1; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(["bash", "-c", piped], cwd=flown, capture_output=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert len(done.stdout.splitlines()) == 1
