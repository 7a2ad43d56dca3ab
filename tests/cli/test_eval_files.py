"""What `waypointctl eval` writes, and what it refuses to replace."""

from __future__ import annotations

import errno
import json
import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.flying import Program
from waypointctl.evaluation.suite import load_suite
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.task.course import Deadline

Make = Callable[..., LoadedPolicy]

SUITE = """\
name: easy
trials: 3
acceptance: {shape: box, size: 2 m}
deadline: {first: 0.2 s, further: 0 s}
cases: [{name: near, waypoints: [[0.2, 0]]}, {name: far, waypoints: [[50, 0]]}]
"""
EASY = ("--suite", "easy.yaml")
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture
def place(yard: Path, make_policy: Make) -> Path:
    """A folder to work in, with the policies `still` and `wild` and a suite."""
    make_policy(yard / "wild", gain=3.0, name="wild")
    (yard / "easy.yaml").write_text(SUITE)
    return yard


def test_several_policies_are_one_table_and_one_list(place: Path, program: Program) -> None:
    code, out, err = program("eval", "still", "wild", *EASY, "--json", "--out", "both.json")
    found = json.loads(out)["evaluations"]
    assert (code, [one["policy"] for one in found]) == (0, ["tiny", "wild"])
    assert [case["trials"] for case in found[0]["cases"]] == [3, 3]
    assert (place / "both.json").read_text() == out
    rows = [" ".join(line.split()) for line in err.splitlines()]
    assert any(row.startswith("wild near") for row in rows)
    assert any(row.startswith("tiny far (50, 0) 0/3") for row in rows)
    alone = json.loads(program("eval", "wild", *EASY, "--json")[1])
    assert alone == found[1]


def test_several_policies_on_the_papers_paths_are_its_tables(
    place: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    hurried = load_suite("paper").model_copy(update={"deadline": Deadline(first_s=0.1)})
    monkeypatch.setattr("waypointctl.cli.evaluation_run.load_suite", lambda name: hurried)
    code, out, _ = program("eval", "still", "wild", "--trials", "1", "--markdown", "tables.md", "--plot", "paths.png")
    assert code == 0
    assert [line[:7] for line in out.splitlines() if line.startswith("Table")] == ["Table 1", "Table 2", "Table 3"]
    assert "| 5 |  | waypoints | state + goal | 90% | not evaluated |" in (place / "tables.md").read_text()
    assert (place / "paths.png").read_bytes().startswith(PNG)


def test_save_writes_beside_each_policy_by_suite_and_acceptance(place: Path, program: Program) -> None:
    for acceptance in ((), ("--acceptance", "radius:20cm"), ("--acceptance", "box:2")):  # the last is the suite's own
        assert program("eval", "still", "wild", *EASY, *acceptance, "--save")[0] == 0
    for name in ("still", "wild"):
        files = sorted(path.name for path in (place / name).glob("*evaluation*"))
        assert files == ["evaluation-easy-radius-0.2m.json", "evaluation-easy.json"]
    narrow = json.loads((place / "still" / files[0]).read_text())
    assert narrow["acceptance"] == {"shape": "radius", "size_m": 0.2}
    assert narrow["suite_acceptance"] == {"shape": "box", "size_m": 2.0}
    assert json.loads((place / "still" / files[1]).read_text())["suite_acceptance"] is None


def test_a_saved_evaluation_with_more_trials_is_replaced_only_by_force(
    place: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    saved = place / "still" / "evaluation-easy.json"
    code, _, err = program("eval", "still", *EASY, "--save", "--out", "found.json")
    assert (code, err) == (0, "written: found.json\nwritten: still/evaluation-easy.json\n")
    before = saved.read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr("waypointctl.cli.evaluation_run.evaluate", lambda *_, **__: pytest.fail("it was evaluated"))
        code, out, err = program("eval", "still", *EASY, "--trials", "2", "--save")
    assert (code, out) == (2, "")
    assert err == (
        "error: still/evaluation-easy.json: has an evaluation with 3 trials of each path; this one has 2\n"
        "  Use --force to replace it, or --trials 3\n"
    )
    assert saved.read_bytes() == before
    assert program("eval", "still", *EASY, "--trials", "2", "--out", "found.json")[0] == 0
    assert program("eval", "still", *EASY, "--trials", "2", "--save", "--force")[0] == 0
    assert json.loads(saved.read_text())["cases"][0]["trials"] == 2
    assert program("eval", "still", *EASY, "--save")[0] == 0


@pytest.mark.parametrize(("given", "text"), [("1", "1 physics thread"), ("2", "2 physics threads")])
def test_the_threads_of_the_physics_are_printed(place: Path, program: Program, given: str, text: str) -> None:
    assert program("eval", "still", *EASY, "--threads", given)[1].splitlines()[-1] == text
    assert re.fullmatch(r"\d+ physics threads? \(default\)", program("eval", "still", *EASY)[1].splitlines()[-1])


def test_a_suite_that_borrows_a_name_is_not_saved(place: Path, program: Program) -> None:
    (place / "easy.yaml").write_text(SUITE.replace("easy", "paper"))
    code, _, err = program("eval", "still", *EASY, "--save")
    assert code == 2
    assert err.startswith("error: a suite that comes with waypointctl has the name 'paper'\n")
    (place / "easy.yaml").write_text(SUITE.replace("easy", "../easy"))
    code, _, err = program("eval", "still", *EASY, "--save")
    assert code == 2
    assert "names a file after the suite, and '../easy' is not a name of letters" in err
    assert not list((place / "still").glob("evaluation*"))


@pytest.mark.parametrize(
    ("option", "name"),
    [("--out", "a.json"), ("--markdown", "a.md"), ("--plot", "a.png"), ("--save", "still/evaluation-easy.json")],
)
def test_what_is_of_another_kind_is_replaced_only_by_force(
    place: Path, program: Program, option: str, name: str
) -> None:
    asked = ("eval", "still", *EASY, *([option] if option == "--save" else [option, name]))
    (place / name).write_text("{}")
    code, out, err = program(*asked)
    assert (code, out) == (2, "")
    assert err.startswith(f"error: {name}: already exists and is not ")
    assert (place / name).read_text() == "{}"
    assert program(*asked, "--force")[0] == 0
    first = (place / name).read_bytes()
    assert program(*asked)[0] == 0
    assert (place / name).read_bytes() == first


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--out y --markdown ./y --plot z", "y: --out and --markdown would both write this file\n  Give --markdown"),
        ("--markdown y --plot y --force", "y: --markdown and --plot would both write this file\n  Give --plot"),
        ("--save --out link/evaluation-easy.json", "link/evaluation-easy.json: --save and --out would both write"),
    ],
)
def test_a_file_that_two_options_would_write_is_refused(
    place: Path, program: Program, options: str, message: str
) -> None:
    (place / "link").symlink_to("still")
    code, out, err = program("eval", "still", "wild", *EASY, *options.split())
    assert (code, out) == (2, "")
    assert err.startswith(f"error: {message}")
    assert not [*place.glob("y"), *place.glob("still/evaluation*")]


@pytest.mark.parametrize(
    ("option", "target", "fault"),
    [
        ("--out", "/proc/x.json", "the folder /proc is not writable"),
        ("--markdown", "/proc/x.md", "the folder /proc is not writable"),
        ("--plot", "/proc/x.png", "the folder /proc is not writable"),
        ("--plot", "nowhere/x.png", "the folder nowhere does not exist"),
        ("--save", "still/evaluation-easy.json", "No space left on device"),
    ],
)
def test_what_cannot_be_written_is_refused_before_anything_is_walked(
    place: Path, program: Program, monkeypatch: pytest.MonkeyPatch, option: str, target: str, fault: str
) -> None:
    def walked(*_: object) -> None:
        pytest.fail("it has begun to walk")

    def full(self: Path) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("waypointctl.cli.evaluation_run.evaluate", walked)
    if option == "--save":
        monkeypatch.setattr(Path, "touch", full)
    code, out, err = program("eval", "still", *EASY, *([option] if option == "--save" else [option, target]))
    assert (code, out) == (2, "")
    assert err.startswith(f"error: {target}: the ")
    assert f" cannot be written: {fault}" in err


@pytest.mark.parametrize(
    "acceptance", ["cube:1", "radius", "radius:", "radius:-1", "box:1 h", "box:nan", ":", "box:1e3"]
)
def test_what_is_no_acceptance_is_refused(place: Path, program: Program, acceptance: str) -> None:
    code, _, err = program("eval", "still", *EASY, "--acceptance", acceptance)
    assert code == 2
    assert err == (
        f"error: --acceptance: {acceptance!r} is not an acceptance region: a shape, box or radius, and a size up to "
        "100 m\n  Such as radius:0.2 or box:50cm\n"
    )


def test_one_policy_that_is_missing_stops_all(place: Path, program: Program) -> None:
    code, _, err = program("eval", "still", "nobody", *EASY, "--save")
    assert (code, "nobody: folder not found" in err) == (2, True)
    assert not list((place / "still").glob("evaluation*"))


def test_a_required_rate_names_the_policy(place: Path, program: Program) -> None:
    code, _, err = program("eval", "still", "wild", *EASY, "--require", "0.5")
    assert (code, err) == (1, "below 50%: tiny far, wild far\n")
