"""Files that are read: regular ones, where they belong, of a bounded size."""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from waypointctl.errors import InputError, MissionError
from waypointctl.input_file import open_input, read_input
from waypointctl.limits import VARIABLE


def fifo(path: Path) -> None:
    os.mkfifo(path)


def linked_fifo(path: Path) -> None:
    os.mkfifo(path.with_name("p"))
    path.symlink_to("p")


def listening(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(str(path))


OTHERS: dict[str, tuple[Callable[[Path], object], str]] = {
    "folder": (Path.mkdir, "is a folder, not a file"),
    "pipe": (fifo, "is a named pipe, not a file"),
    "socket": (listening, "is a socket, not a file"),
    "zero": (lambda path: path.symlink_to("/dev/zero"), "is a device, not a file"),
    "terminal": (lambda path: path.symlink_to("/dev/tty"), "is a device, not a file|cannot be read"),
    "nothing": (lambda path: None, "there is no such file"),
    "dangling": (lambda path: path.symlink_to("nowhere"), "there is no such file"),
    "memory": (lambda path: path.symlink_to("/proc/self/mem"), "cannot be read: Input/output error"),
    "loop": (lambda path: path.symlink_to(path.name), "cannot be read: Too many levels"),
    "pipe behind a link": (linked_fifo, "is a named pipe"),
}


@pytest.mark.parametrize("name", OTHERS)
def test_what_is_no_regular_file_is_refused_at_once(tmp_path: Path, name: str) -> None:
    make, message = OTHERS[name]
    path = tmp_path / "given"
    make(path)
    with pytest.raises(MissionError, match=message) as caught:
        read_input(path, 10, MissionError)
    assert caught.value.where == str(path)


@pytest.mark.parametrize("name", ["x" * 5000, "a\0b"])
def test_a_name_that_cannot_be_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_input(tmp_path / name, 10)


def test_a_file_of_the_largest_size_is_read_and_a_larger_one_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "given"
    path.write_bytes(b"x" * 1024)
    assert read_input(path, 1024) == b"x" * 1024
    path.write_bytes(b"x" * 1025)
    with pytest.raises(InputError, match="is larger than the 1 KiB that are read\n  Use less"):
        read_input(path, 1024, hint="use less")
    monkeypatch.setenv(VARIABLE, "policy-file=1024")
    with pytest.raises(InputError) as caught:
        read_input(path, "policy-file")
    assert caught.value.problem == "has 1,025 B; the limit policy-file is 1 KiB"
    assert "--limit policy-file=2KiB COMMAND" in (caught.value.hint or "")
    with path.open("ab") as file:
        file.truncate(2**40)  # sparse: it takes no room
    with pytest.raises(InputError, match="is larger than"):
        read_input(path, 1024)
    with pytest.raises(
        InputError, match=r"has 1,024 GiB; the limit policy-file is 1 KiB\n.*policy-file=1024GiB COMMAND"
    ):
        read_input(path, "policy-file")


@pytest.mark.parametrize("named", ["outside.txt", "beyond/file.txt", "sub/up.txt"])
def test_a_link_that_leads_out_of_the_folder_is_refused(tmp_path: Path, named: str) -> None:
    folder, elsewhere = tmp_path / "folder", tmp_path / "folder-2"  # one name begins with the other
    (folder / "sub").mkdir(parents=True)
    elsewhere.mkdir()
    (elsewhere / "file.txt").write_text("secret")
    (folder / "outside.txt").symlink_to(elsewhere / "file.txt")
    (folder / "beyond").symlink_to(elsewhere)
    (folder / "sub" / "up.txt").symlink_to("../../folder-2/file.txt")
    with pytest.raises(InputError, match="leads out of the folder") as caught:
        read_input(folder / named, 100, within=folder)
    assert "secret" not in str(caught.value)
    assert read_input(folder / named, 100) == b"secret", "named by the user it is read"


def test_links_within_the_folder_and_to_the_folder_are_followed(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    (folder / "sub").mkdir(parents=True)
    (folder / "sub" / "file.txt").write_text("text")
    (folder / "near.txt").symlink_to("sub/file.txt")
    (tmp_path / "link").symlink_to("folder")
    for given in (folder, tmp_path / "link"):
        assert read_input(given / "near.txt", 100, within=given) == b"text"
        with open_input(given / "sub" / "file.txt", within=given) as file:
            assert file.read() == b"text"
