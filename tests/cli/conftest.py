"""A folder with missions to fly, and waypointctl to fly them with."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.cli.flying import EASY, FAR, LONG, Program
from waypointctl.cli.main import main
from waypointctl.policy.bundle import LoadedPolicy


@pytest.fixture(autouse=True)
def _signals() -> Iterator[None]:
    """Give signals their meaning, which nohup takes from them, and give it back: the program takes it as it ends."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def yard(tmp_path: Path, make_policy: Callable[..., LoadedPolicy], monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with the policy `still` and missions."""
    make_policy(tmp_path / "still", gain=0.0)
    for name, text in (("easy", EASY), ("far", FAR), ("long", LONG)):
        (tmp_path / f"{name}.yaml").write_text(text)
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("COLUMNS", raising=False)
    return tmp_path


@pytest.fixture
def program(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Program:
    """Run waypointctl in this process: program(*arguments) -> exit code, stdout, stderr."""

    def run(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["waypointctl", *arguments])
        with pytest.raises(SystemExit) as caught:
            main()
        return (int(caught.value.code or 0), *capfd.readouterr())

    return run
