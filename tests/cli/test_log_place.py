from __future__ import annotations

import os
from pathlib import Path

import pytest

from waypointctl.cli.log_place import claimed
from waypointctl.errors import OutputError


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_two_flights_at_once_get_two_names() -> None:
    with claimed("m", None, force=False) as first, claimed("m", None, force=False) as second:
        assert (str(first), str(second)) == ("logs/m.mcap", "logs/m-2.mcap")


def test_two_flights_at_once_cannot_have_the_same_place(folder: Path) -> None:
    out = folder / "log.mcap"
    with claimed("m", out, force=False), pytest.raises(OutputError, match="another flight is writing it"):
        claimed("m", out, force=False).__enter__()


def test_a_claim_that_came_to_nothing_is_given_up(folder: Path) -> None:
    with pytest.raises(RuntimeError), claimed("m", folder / "log.mcap", force=False):
        raise RuntimeError
    assert not list(folder.iterdir())


def test_what_has_been_written_stays(folder: Path) -> None:
    with claimed("m", folder / "log.mcap", force=False):
        (folder / "log.mcap.part").write_bytes(b"half a flight")
    assert [path.name for path in folder.iterdir()] == ["log.mcap.part"]


def test_force_replaces_what_a_killed_flight_left(folder: Path) -> None:
    (folder / "log.mcap.part").write_bytes(b"half a flight")
    with claimed("m", folder / "log.mcap", force=True) as path:
        assert path.with_name("log.mcap.part").stat().st_size == 0


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n and a flight"])
def test_force_replaces_a_log_or_an_empty_file(folder: Path, content: bytes) -> None:
    (folder / "log.mcap").write_bytes(content)
    with claimed("m", folder / "log.mcap", force=True) as path:
        assert path == folder / "log.mcap"


@pytest.mark.parametrize("force", [True, False])
def test_what_is_no_regular_file_is_never_replaced(folder: Path, force: bool) -> None:
    os.mkfifo(folder / "pipe")
    with pytest.raises(OutputError, match=r"pipe: is not a regular file, .*\n  Name another file") as caught:
        claimed("m", folder / "pipe", force=force).__enter__()
    assert "--force" not in str(caught.value)
    assert [path.name for path in folder.iterdir()] == ["pipe"]
    assert (folder / "pipe").is_fifo()


def test_a_name_that_is_too_long_is_refused(folder: Path) -> None:
    with pytest.raises(OutputError, match="cannot be written: File name too long"):
        claimed("m", folder / ("x" * 5000), force=True).__enter__()
