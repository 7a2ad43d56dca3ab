from __future__ import annotations

import os
from pathlib import Path

import pytest

from waypointctl.cli.log_place import claimed
from waypointctl.errors import OutputError
from waypointctl.paths import lock


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


def test_a_flight_that_was_killed_is_told_from_one_under_way(folder: Path) -> None:
    (folder / "log.mcap.part").write_bytes(b"half a flight")
    with pytest.raises(OutputError, match=r"a flight was killed\n  `waypointctl run --resume` continues it"):
        claimed("m", folder / "log.mcap", force=False).__enter__()


@pytest.mark.parametrize("name", ["log.mcap", "log.mcap.part"])
def test_force_leaves_a_flight_that_is_under_way_alone(folder: Path, name: str) -> None:
    (folder / name).write_bytes(b"\x89MCAP0\r\n half a flight")
    with (folder / name).open("rb") as writer:
        assert lock(writer)
        for force in (True, False):
            with pytest.raises(OutputError, match="another flight is writing it"):
                claimed("m", folder / "log.mcap", force=force).__enter__()
    assert (folder / name).read_bytes() == b"\x89MCAP0\r\n half a flight"
    with claimed("m", folder / "log.mcap", force=True):
        pass


def test_force_leaves_a_place_that_is_claimed_alone(folder: Path) -> None:
    out = folder / "log.mcap"
    with claimed("m", out, force=False), pytest.raises(OutputError, match="another flight is writing it"):
        claimed("m", out, force=True).__enter__()


def test_a_log_keeps_its_place_until_its_flight_has_told_of_it(folder: Path) -> None:
    out = folder / "log.mcap"
    with claimed("m", out, force=False):
        (folder / "log.mcap.part").write_bytes(b"\x89MCAP0\r\n a flight")
        (folder / "log.mcap.part").replace(out)
        with pytest.raises(OutputError, match="another flight is writing it"):
            claimed("m", out, force=True).__enter__()


def test_what_a_link_in_the_place_of_a_part_leads_to_is_left_alone(folder: Path) -> None:
    (folder / "diary").write_text("dear diary")
    (folder / "log.mcap.part").symlink_to(folder / "diary")
    with pytest.raises(OutputError, match="cannot be written"):
        claimed("m", folder / "log.mcap", force=True).__enter__()
    assert (folder / "diary").read_text() == "dear diary"


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


def test_a_pipe_in_the_place_of_the_part_is_named(folder: Path) -> None:
    os.mkfifo(folder / "log.mcap.part")
    with pytest.raises(OutputError, match=r"log\.mcap\.part, or it is not a regular file"):
        claimed("m", folder / "log.mcap", force=True).__enter__()
    assert (folder / "log.mcap.part").is_fifo()


def test_a_name_that_is_too_long_is_refused(folder: Path) -> None:
    with pytest.raises(OutputError, match="cannot be written: File name too long"):
        claimed("m", folder / ("x" * 5000), force=True).__enter__()
