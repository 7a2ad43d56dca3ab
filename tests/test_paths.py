from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from waypointctl.errors import OutputError
from waypointctl.paths import (
    folder_fault,
    is_being_written,
    lock,
    open_lock,
    refuse_other_content,
    refuse_unwritable_file,
    refuse_unwritable_folder,
    write_whole,
)

TOO_LONG = "x" * 5000


def test_a_folder_has_no_fault_and_all_else_says_which(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert folder_fault(tmp_path) is None
    assert folder_fault(tmp_path / "none") == "folder not found"
    assert folder_fault(tmp_path / "file" / "none") == "folder not found"
    assert folder_fault(tmp_path / "file") == "is a file, not a folder"
    assert folder_fault(Path(TOO_LONG)) == "cannot be read: File name too long"
    assert folder_fault(Path("a\0b")) == "cannot be read: embedded null byte"


def refusal(path: Path) -> str:
    with pytest.raises(OutputError) as caught:
        refuse_unwritable_file(path, "the picture")
    assert caught.value.where == str(path)
    return caught.value.problem


def test_a_file_that_can_be_written_passes(tmp_path: Path) -> None:
    refuse_unwritable_file(tmp_path / "new.png", "the picture")
    (tmp_path / "old.png").touch()
    refuse_unwritable_file(tmp_path / "old.png", "the picture")
    assert [path.name for path in tmp_path.iterdir()] == ["old.png"]


def test_a_file_that_cannot_be_written_says_why(tmp_path: Path) -> None:
    assert refusal(tmp_path) == "the picture cannot be written: this is a folder"
    assert (
        refusal(tmp_path / "none" / "a.png")
        == f"the picture cannot be written: the folder {tmp_path}/none does not exist"
    )
    assert refusal(tmp_path / TOO_LONG) == "the picture cannot be written: File name too long"


def test_what_permissions_allow_and_the_system_does_not_is_refused() -> None:
    assert refusal(Path("/proc/x.png")) == "the picture cannot be written: the folder /proc is not writable"
    assert refusal(Path("/proc/version")).startswith("the picture cannot be written: ")


def test_a_full_disk_is_found_before_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: Path) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "touch", full)
    assert refusal(tmp_path / "a.png") == "the picture cannot be written: No space left on device"


def test_a_device_passes_and_is_not_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, "touch", None)
    refuse_unwritable_file(Path(os.devnull), "the picture")


def test_a_link_stays_a_link_and_its_file_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "file").write_bytes(b"old")
    (tmp_path / "link").symlink_to(tmp_path / "there" / "file")
    refuse_unwritable_file(tmp_path / "link", "the letter")
    write_whole(tmp_path / "link", b"new", "the letter")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "there" / "file").read_bytes() == b"new"
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "link", "there"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_file_without_permission(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    assert refusal(tmp_path / "a.png") == f"the picture cannot be written: the folder {tmp_path} is not writable"


@pytest.mark.parametrize("content", [None, b"", b"\x89PNG\r\n\x1a\n"])
def test_an_empty_file_or_one_of_its_kind_may_be_replaced(tmp_path: Path, content: bytes | None) -> None:
    if content is not None:
        (tmp_path / "a.png").write_bytes(content)
    refuse_other_content(tmp_path / "a.png", b"\x89PNG", "a PNG")


def test_anything_else_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "log.mcap").write_bytes(b"\x89MCAP0\r\n")
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(tmp_path / "pipe")
    for name, problem in (("log.mcap", "is not a PNG"), ("pipe", "not a regular"), ("link", "not a regular")):
        with pytest.raises(OutputError, match=problem):
            refuse_other_content(tmp_path / name, b"\x89PNG", "a PNG")


def test_a_file_is_replaced_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_whole(tmp_path / "a", b"first", "the letter")
    with (tmp_path / "a").open("rb") as reading:
        write_whole(tmp_path / "a", b"second", "the letter")
        assert (reading.read(), (tmp_path / "a").read_bytes()) == (b"first", b"second")

    def full(self: Path, target: Path) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(
        OutputError,
        match=r"a: the letter cannot be written: No space left on device\n  Give a path in a writable folder",
    ):
        write_whole(tmp_path / "a", b"third", "the letter")
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("a", b"second")]


def test_a_file_whose_name_cannot_be_is_refused_and_a_device_is_written_to(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="the letter cannot be written: File name too long"):
        write_whole(tmp_path / TOO_LONG, b"text", "the letter")
    with pytest.raises(OutputError, match=r"the letter cannot be written: the folder .*none does not exist"):
        write_whole(tmp_path / "none" / "a", b"text", "the letter")
    write_whole(Path(os.devnull), b"text", "the letter")
    assert Path(os.devnull).is_char_device()


def test_a_folder_that_cannot_be_looked_up_is_refused(tmp_path: Path) -> None:
    refuse_unwritable_folder(tmp_path / "a" / "b")
    assert not list(tmp_path.iterdir())
    with pytest.raises(OutputError, match="the folder cannot be created: File name too long"):
        refuse_unwritable_folder(tmp_path / TOO_LONG)


@pytest.mark.parametrize("place", ["/proc/x", "/proc"])
def test_a_folder_that_permissions_allow_and_the_system_does_not_is_refused(place: str) -> None:
    with pytest.raises(OutputError, match=rf"{place}: the folder cannot be written: the folder /proc is not writable"):
        refuse_unwritable_folder(Path(place))


def test_a_name_that_leaves_no_room_for_the_staging_folders_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="File name too long"):
        refuse_unwritable_folder(tmp_path / ("x" * 250))


def test_the_file_that_the_output_goes_into_is_no_target(tmp_path: Path) -> None:
    program = (
        "import sys; from pathlib import Path\n"
        "from waypointctl.paths import refuse_unwritable_file\n"
        "try: refuse_unwritable_file(Path(sys.argv[1]), 'the picture')\n"
        "except Exception as error: print(error, file=sys.stderr)\n"
    )
    out = tmp_path / "out.json"
    for name in ("/dev/stdout", str(out)):
        with out.open("wb") as stdout:
            done = subprocess.run(
                [sys.executable, "-c", program, name], stdout=stdout, stderr=subprocess.PIPE, text=True, check=False
            )
        assert "the picture cannot be written: standard output or error goes into this very file" in done.stderr


def test_a_lock_is_made_and_a_link_or_a_pipe_in_its_place_is_left_alone(tmp_path: Path) -> None:
    with open_lock(tmp_path / ".lock"), open_lock(tmp_path / ".lock"):
        assert (tmp_path / ".lock").is_file()
    (tmp_path / "other.txt").write_text("kept")
    (tmp_path / "link").symlink_to("other.txt")
    os.mkfifo(tmp_path / "pipe")
    for name in ("link", "pipe"):
        with pytest.raises(OSError, match=name):
            open_lock(tmp_path / name)
    assert (tmp_path / "other.txt").read_text() == "kept"


def test_a_file_that_a_flight_is_writing_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "log.mcap.part"
    path.write_bytes(b"half a flight")
    with path.open("rb") as flight:
        assert lock(flight)
        assert is_being_written(path)
        with pytest.raises(OutputError, match="a flight under way is writing this file"):
            refuse_unwritable_file(path, "the evaluation")
    assert not is_being_written(path)
    refuse_unwritable_file(path, "the evaluation")
    assert path.read_bytes() == b"half a flight"
