from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from waypointctl.cli.main import main
from waypointctl.policy.bundle import LoadedPolicy

Make = Callable[..., LoadedPolicy]
Run = Callable[..., tuple[int, str, str]]

SUITE = """\
name: easy
acceptance: {size_m: 2}
deadline: {first_s: 0.2}
cases: [{name: near, waypoints: [[0.2, 0]]}, {name: far, waypoints: [[50, 0]]}]
"""
LONG = """\
name: long
deadline: {first: 0.2 s}
courses: [{name: long, perimeter: legs, count: 20, leg: [5 m, 6 m]}]
"""


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Run:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "160")

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["waypointctl", *arguments])
        with pytest.raises(SystemExit) as caught:
            main()
        return (int(caught.value.code or 0), *capfd.readouterr())

    return call


def line_of(text: str, start: str) -> str:
    """Return the table's line that starts so, its cells one space apart."""
    return " ".join(next(line for line in text.splitlines() if line.strip().startswith(start)).split())


def test_it_lists_the_policies_in_policies(tmp_path: Path, make_policy: Make, run: Run) -> None:
    make_policy(tmp_path / "policies" / "first")
    make_policy(tmp_path / "policies" / "second")
    (tmp_path / "policies" / "untrained").mkdir()
    code, out, err = run("policies")
    assert (code, err) == (0, "")
    assert line_of(out, "policies/first") == "policies/first ant egocentric 0 not evaluated"
    assert line_of(out, "policies/second")
    assert "untrained" not in out


def test_it_lists_another_folder_with_the_results_in_every_suite(tmp_path: Path, make_policy: Make, run: Run) -> None:
    make_policy(tmp_path / "mine" / "still", gain=0.0)
    make_policy(tmp_path / "mine" / "untested")
    (tmp_path / "easy.yaml").write_text(SUITE)
    (tmp_path / "long.yaml").write_text(LONG)
    for suite in (("easy.yaml",), ("long.yaml",), ("easy.yaml", "--acceptance", "radius:1")):
        assert run("eval", "mine/still", "--suite", *suite, "--trials", "2", "--save")[0] == 0
    _, out, err = run("policies", "mine")
    assert err == ""
    assert " ".join(out.splitlines()[0].split()) == "policy robot layout steps easy easy, radius 1 m long"
    cells = "0-100% in 2 cases 0-100% in 2 cases 0.0%, legs 0.00%"
    assert line_of(out, "mine/still") == f"mine/still ant egocentric 0 {cells}"
    assert line_of(out, "mine/untested") == "mine/untested ant egocentric 0 not evaluated"


@pytest.mark.parametrize("columns", ["60", "80", "120"])
def test_names_are_whole_on_a_narrow_terminal_and_what_is_left_out_is_said(
    tmp_path: Path, make_policy: Make, run: Run, monkeypatch: pytest.MonkeyPatch, columns: str
) -> None:
    folders = [f"policies/{name}" for name in ("a-long-walker", "policy1")]
    for folder in folders:
        make_policy(tmp_path / folder, gain=0.0)
    (tmp_path / "easy.yaml").write_text(SUITE)
    for size in ("1", "1.5", "1.25"):
        run("eval", *folders, "--suite", "easy.yaml", "--acceptance", f"radius:{size}", "--trials", "1", "--save")
    monkeypatch.setenv("COLUMNS", columns)
    _, out, err = run("policies", "policies")
    assert err == ""
    assert max(map(len, out.splitlines())) <= int(columns)
    assert [line.split()[0] for line in out.splitlines() if line.startswith("policies/")] == folders
    told = " ".join(out.split()).partition("left out: ")[2]
    assert told.endswith("; a wider terminal or --json shows them") == (columns != "120")
    assert ("layout" in told, "'easy, radius 1 m'" in told) == (columns != "120", columns == "60")


def test_results_of_another_policy_are_told_and_left_out(tmp_path: Path, make_policy: Make, run: Run) -> None:
    make_policy(tmp_path / "mine" / "still", gain=0.0)
    (tmp_path / "easy.yaml").write_text(SUITE)
    run("eval", "mine/still", "--suite", "easy.yaml", "--trials", "1", "--save")
    make_policy(tmp_path / "mine" / "still", seed=1)
    _, out, err = run("policies", "mine")
    assert "not evaluated" in out
    assert err == "warning: mine/still/evaluation-easy.json: of another policy than the one in this folder\n"


def test_the_built_in_suites_come_first(tmp_path: Path, make_policy: Make, run: Run) -> None:
    make_policy(tmp_path / "mine" / "still", gain=0.0)
    (tmp_path / "any.yaml").write_text(SUITE.replace("easy", "any"))
    run("eval", "mine/still", "--suite", "any.yaml", "--trials", "1", "--save")
    saved = json.loads((tmp_path / "mine" / "still" / "evaluation-any.json").read_text())
    for suite, name in (("station", "-station"), ("region", "-region"), ("paper", "")):
        text = json.dumps(saved | {"suite": suite})
        (tmp_path / "mine" / "still" / f"evaluation{name}.json").write_text(text)
    (entry,) = json.loads(run("policies", "mine", "--json")[1])["policies"]
    assert [found["suite"] for found in entry["evaluations"]] == ["paper", "region", "station", "any"]
    assert entry["evaluation"] == entry["evaluations"][0]


def test_a_damaged_policy_and_a_damaged_evaluation_are_told_beside_the_sound_ones(
    tmp_path: Path, make_policy: Make, run: Run
) -> None:
    for name in ("a", "b", "c"):
        make_policy(tmp_path / "policies" / name)
    (tmp_path / "policies" / "a" / "policy.onnx").unlink()
    (tmp_path / "policies" / "b" / "evaluation.json").write_text("{}")
    code, out, err = run("policies")
    assert code == 0
    assert line_of(out, "policies/a") == "policies/a damaged"
    assert line_of(out, "policies/c")
    assert "warning: policies/a: no policy.onnx" in err
    assert "warning: policies/b/evaluation.json: not an evaluation: " in err


def test_the_list_as_json(tmp_path: Path, make_policy: Make, run: Run) -> None:
    policy = make_policy(tmp_path / "policies" / "first")
    _, out, _ = run("policies", "policies", "--json")
    (entry,) = json.loads(out)["policies"]
    assert (entry["name"], entry["shipped"]) == ("first", False)
    assert (entry["folder"], entry["policy_sha256"]) == ("policies/first", policy.sha256)
    assert entry["manifest"] == json.loads(policy.files["manifest.json"])
    assert (entry["evaluation"], entry["evaluations"], entry["faults"]) == (None, [], [])


def test_an_empty_folder_says_what_to_do(tmp_path: Path, run: Run) -> None:
    (tmp_path / "policies").mkdir()
    assert run("policies", "policies") == (
        0,
        "",
        "no policies in policies; `waypointctl train RECIPE.yaml` makes one\n",
    )


def test_show_prints_the_manifest_as_it_is(tmp_path: Path, make_policy: Make, run: Run) -> None:
    policy = make_policy(tmp_path / "first")
    assert run("policies", "show", "first") == (0, policy.files["manifest.json"].decode(), "")


def test_show_as_json_is_the_entry_that_the_list_has(tmp_path: Path, make_policy: Make, run: Run) -> None:
    make_policy(tmp_path / "policies" / "first")
    code, told, err = run("policies", "show", "first", "--json")
    assert (code, err) == (0, "")
    assert json.loads(told) == json.loads(run("policies", "list", "policies", "--json")[1])["policies"][0]


def test_without_a_folder_it_lists_the_shipped_policies_and_those_in_policies(
    tmp_path: Path, make_policy: Make, run: Run
) -> None:
    assert line_of(run("policies")[1], "ant-waypoint").startswith("ant-waypoint (shipped) ant egocentric 16,011,264")
    make_policy(tmp_path / "policies" / "mine")
    listed = json.loads(run("policies", "--json")[1])["policies"]
    assert [(entry["name"], entry["shipped"]) for entry in listed] == [("ant-waypoint", True), ("mine", False)]
    # One of the same name in ./policies is what the name finds, and the shipped one is not.
    own = make_policy(tmp_path / "policies" / "ant-waypoint")
    listed = json.loads(run("policies", "--json")[1])["policies"]
    assert [(entry["folder"], entry["shipped"]) for entry in listed] == [
        ("policies/ant-waypoint", False),
        ("policies/mine", False),
    ]
    assert run("policies", "show", "ant-waypoint")[1] == own.files["manifest.json"].decode()


@pytest.mark.parametrize("arguments", [("policies", "nowhere"), ("policies", "show", "nowhere")])
def test_a_folder_that_is_not_there_is_refused(run: Run, arguments: tuple[str, ...]) -> None:
    code, out, err = run(*arguments)
    assert (code, out) == (2, "")
    assert "folder not found" in err
