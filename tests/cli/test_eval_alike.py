"""Several policies in one evaluation that could be taken for one another."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.flying import Program
from tests.cli.test_eval_files import EASY, SUITE
from waypointctl.policy.bundle import LoadedPolicy


@pytest.fixture
def place(yard: Path, make_policy: Callable[..., LoadedPolicy]) -> Path:
    """A folder with the policy `still`, a copy of it, and another policy of its name; and a suite."""
    shutil.copytree(yard / "still", yard / "copies" / "still")
    make_policy(yard / "namesake", gain=0.0, seed=1)
    (yard / "easy.yaml").write_text(SUITE)
    return yard


def labels(table: str) -> list[str]:
    return [line.split()[0] for line in table.splitlines() if line.split()[1:2] == ["near"]]


def test_copies_are_told_apart_by_their_folders_and_said_to_be_the_same(place: Path, program: Program) -> None:
    code, out, _ = program("eval", "still", "copies/still", *EASY, "--markdown", "t.md", "--plot", "t.png")
    assert (code, labels(out)) == (0, ["still", "copies/still"])
    note = "still and copies/still are one and the same policy: SHA-256 "
    assert note in out
    assert note in (place / "t.md").read_text()
    assert "| copies/still | near |" in (place / "t.md").read_text()


def test_other_policies_of_the_same_name_are_told_apart_too(place: Path, program: Program) -> None:
    code, out, err = program("eval", "still", "namesake", *EASY, "--require", "0.5")
    assert (code, labels(out)) == (1, ["still", "namesake"])
    assert out.splitlines()[-2] == "2 different policies are called 'tiny'"
    assert err == "below 50%: still far, namesake far\n"


def test_the_same_folder_twice_is_numbered(place: Path, program: Program) -> None:
    _, out, _ = program("eval", "still", "still", *EASY)
    assert "still (1) and still (2) are one and the same policy" in out
