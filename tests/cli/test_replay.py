from __future__ import annotations

import json
import os
import pty
import re
import signal
import struct
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.cli.flying import EASY, Program, start
from waypointctl.flight.fly import fly
from waypointctl.flight.header import platform_facts
from waypointctl.log.messages import Action, Message
from waypointctl.log.writer import LogWriter
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay import contents


@pytest.fixture(scope="module")
def easy_log(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> bytes:
    """The log of the mission easy.yaml."""
    folder = tmp_path_factory.mktemp("easy")
    make_policy(folder / "still", gain=0.0)
    (folder / "easy.yaml").write_text(EASY)
    fly(folder / "easy.yaml", log=folder / "log.mcap")
    return (folder / "log.mcap").read_bytes()


@pytest.fixture
def alone(tmp_path: Path, easy_log: bytes, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with nothing in it but a log."""
    (tmp_path / "log.mcap").write_bytes(easy_log)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("COLUMNS", raising=False)
    return tmp_path


def test_a_log_alone_is_proved_and_told(alone: Path, program: Program) -> None:
    code, out, err = program("replay", "log.mcap")
    assert (code, err) == (0, "")
    first, *_ = out.splitlines()
    assert first == "EXACT: 102 control steps replayed, identical byte for byte"
    assert "success: 2 of 2 waypoints reached in 2.04 s" in out
    # Here is reached at 0.5 s on board and known half a second later; the command's round trip takes 1 s.
    assert re.search(r"here +\(0, 0\) +box 3 m +0\.50 +0\.52 +1\.02 +0\.50\n", out)
    assert re.search(
        r"1 +upload_plan here, there \[/bold\] +0\.00 +0\.50 +1\.00 +1\.54 +2\.04 +0\.50 +0\.50 +1\.00 +completed", out
    )
    assert re.search(r"\ntotal +-?[\d,.]+ ", out)
    assert "● robot" in out
    assert list(alone.iterdir()) == [alone / "log.mcap"]


def test_verify_tells_no_story(alone: Path, program: Program) -> None:
    code, out, _ = program("replay", "log.mcap", "--verify")
    assert code == 0
    assert out.startswith("EXACT: ")
    assert "waypoint  " not in out


def test_verify_as_json(alone: Path, program: Program) -> None:
    code, out, err = program("replay", "log.mcap", "--verify", "--json")
    found = json.loads(out)
    assert code == 0
    assert (found["verdict"], found["steps"], found["first_divergence"]) == ("exact", 102, None)
    assert found["reason"].startswith("102 control steps")
    assert "summary" not in found
    assert err.startswith("EXACT: ")


def test_strict_accepts_only_the_first_verdict(alone: Path, program: Program, monkeypatch: pytest.MonkeyPatch) -> None:
    assert program("replay", "log.mcap", "--verify", "--strict")[0] == 0
    elsewhere = dict(platform_facts()) | {"source": "another"}
    monkeypatch.setattr(contents, "platform_facts", lambda: elsewhere)
    code, out, _ = program("replay", "log.mcap", "--verify", "--json")
    found = json.loads(out)
    assert (code, found["verdict"]) == (0, "equivalent")
    assert len(found["not_compared"]) == 1
    code, out, _ = program("replay", "log.mcap", "--verify", "--strict")
    assert code == 1
    assert out.startswith("EQUIVALENT: 102 control steps replayed, physics and messages identical bit for bit\n")
    assert "\n  not compared: the program and processor named in the log: waypointctl's source was " in out


def test_the_story_as_json(alone: Path, program: Program) -> None:
    found = json.loads(program("replay", "log.mcap", "--json")[1])
    summary = found["summary"]
    assert found["verdict"] == "exact"
    assert (summary["mission"], summary["outcome"], summary["control_steps"]) == ("easy", "success", 102)
    assert [(one["name"], one["reached_s"], one["known_s"]) for one in summary["waypoints"]] == [
        ("here", 0.52, 1.02),
        ("there [/bold]", 1.54, 2.04),
    ]
    (command,) = summary["commands"]
    assert (command["uplink_s"], command["downlink_s"], command["round_trip_s"]) == (0.5, 0.5, 1.0)
    assert sum(summary["reward"].values()) == pytest.approx(summary["reward_total"])
    assert summary["moving_s"] + summary["stopped_s"] == pytest.approx(2.04)


def test_a_log_that_is_not_what_happened_exits_with_1(yard: Path, program: Program) -> None:
    class Flipped(LogWriter):
        def __call__(self, message: Message) -> None:
            if isinstance(message, Action) and message.step == 40:
                message.applied.view(np.int64)[3] ^= 1
            super().__call__(message)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("waypointctl.flight.fly.LogWriter", Flipped)
        assert program("run", "easy.yaml", "--out", "log.mcap")[0] == 0
    code, out, err = program("replay", "log.mcap", "--json")
    found = json.loads(out)
    assert code == 1
    assert found["verdict"] == "diverged"
    assert found["first_divergence"]["step"] == 40
    assert "/action" in found["first_divergence"]["topic"]
    assert found["summary"]["outcome"] == "success"
    assert err.startswith("DIVERGED: ")
    assert re.search(r"\n  logged +\S.*\n  replayed +\S", err)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (None, "no such log"),
        (b"", "is empty"),
        (b"PK\x03\x04 and so on", "is not an MCAP file"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "is a Git LFS pointer"),
    ],
)
def test_what_is_no_log_is_refused(yard: Path, program: Program, content: bytes | None, problem: str) -> None:
    if content is not None:
        (yard / "log.mcap").write_bytes(content)
    for more in ((), ("--verify", "--json"), ("--png", "f.png"), ("--rate", "2")):
        code, out, err = program("replay", "log.mcap", *more)
        assert code == 2
        assert err.startswith(f"error: log.mcap: {problem}")
        if "--json" in more:
            told = json.loads(out)
            assert told["exit_code"] == 2
            assert told["error"]["where"] == "log.mcap"
            assert told["error"]["problem"].startswith(problem)
        else:
            assert out == ""
    assert not (yard / "f.png").exists()


def test_a_log_that_is_cut_short_is_refused(alone: Path, program: Program) -> None:
    whole = (alone / "log.mcap").read_bytes()
    (alone / "log.mcap").write_bytes(whole[: len(whole) // 2])
    code, _, err = program("replay", "log.mcap")
    assert code == 2
    assert "is cut short" in err


def test_the_picture(alone: Path, program: Program) -> None:
    code, _, err = program("replay", "log.mcap", "--verify", "--png", "f.png")
    assert (code, err) == (0, "written: f.png\n")
    assert struct.unpack(">II", (alone / "f.png").read_bytes()[16:24]) == (1600, 1000)


@pytest.mark.parametrize("png", ["none/such.png", "."])
def test_a_picture_that_cannot_be_written_is_refused_first(alone: Path, program: Program, png: str) -> None:
    code, out, err = program("replay", "log.mcap", "--png", png)
    assert (code, out) == (2, "")
    assert err.startswith(f"error: {png}: ")


def test_a_picture_replaces_a_picture_and_nothing_else(alone: Path, program: Program) -> None:
    before = (alone / "log.mcap").read_bytes()
    code, out, err = program("replay", "log.mcap", "--png", "log.mcap")
    assert (code, out) == (2, "")
    assert err == "error: log.mcap: already exists and is not a PNG\n  Name another file.\n"
    assert (alone / "log.mcap").read_bytes() == before
    for _ in range(2):
        assert program("replay", "log.mcap", "--verify", "--png", "f.png")[0] == 0


def test_shown_again_it_takes_its_time(alone: Path, program: Program) -> None:
    began = time.monotonic()
    code, out, err = program("replay", "log.mcap", "--rate", "2", "--start-offset", "1")
    assert (code, out) == (0, "")
    assert time.monotonic() - began >= 0.5  # what is left, 1.02 s, at twice the pace
    assert err.splitlines()[-1] == "     2.040 s  operator  success: 2 of 2 waypoints reached in 2.04 s"


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (("--rate", "0"), "above 0"),
        (("--start-offset", "-1"), "at least 0"),
        (("--start-offset", "nan"), "at least 0"),
        (("--start-offset", "99"), "the flight is over at 2.04 s"),
        (("--start-paused",), "needs a terminal"),
        (("--loop", "--verify"), "cannot be used with --verify"),
        (("--rate", "1", "--json"), "cannot be used with --verify"),
    ],
)
def test_what_cannot_be_shown_is_refused(
    alone: Path, program: Program, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...], problem: str
) -> None:
    monkeypatch.setattr("sys.stdin", None)
    code, out, err = program("replay", "log.mcap", *options)
    assert (code, out) == (2, "")
    assert problem in err


def test_keys_steer_the_playback(alone: Path) -> None:
    master, slave = pty.openpty()
    playing = start(
        alone, "replay", "log.mcap", "--start-paused", "--loop", "--rate", "8", stdin=slave, stdout=slave, stderr=slave
    )
    os.close(slave)

    def shows(wanted: bytes) -> None:
        shown = b""
        while wanted not in shown:
            shown += os.read(master, 4096)

    shows(b"paused: space")
    os.write(master, b" ")
    shows(b"x8")
    os.write(master, b"+")
    shows(b"x16")
    os.write(master, b"-")
    shows(b"x8")
    os.write(master, b" ")
    shows(b"paused")
    os.write(master, b"q")
    while True:
        try:
            os.read(master, 4096)
        except OSError:
            break
    assert playing.wait(60) == 0


def test_a_playback_can_be_interrupted(alone: Path) -> None:
    playing = start(alone, "replay", "log.mcap", "--rate", "0.01", stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert playing.stderr is not None
    playing.stderr.readline()
    playing.send_signal(signal.SIGTERM)
    playing.communicate(timeout=60)
    assert playing.returncode == 130
