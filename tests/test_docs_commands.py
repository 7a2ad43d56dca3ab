"""A command that stands in the docs beside a table gives that table: the same seed, trials, paths and policy."""

from __future__ import annotations

import re
import runpy
import shlex
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import pytest
import typer.main

from waypointctl.cli.app import app
from waypointctl.cli.evaluation_run import chosen_suite
from waypointctl.cli.study import rtts_of
from waypointctl.evaluation.result import read_evaluation
from waypointctl.evaluation.saved import saved_name
from waypointctl.evaluation.suite import BUILT_IN
from waypointctl.policy.bundle import load_policy
from waypointctl.studies.delay import read_study
from waypointctl.training.selection import EvaluationRecipe

ROOT = Path(__file__).resolve().parents[1]
PAGES = (ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")))


@pytest.fixture(autouse=True)
def _in_the_checkout(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)


def lines_of(page: Path, start: str) -> list[str]:
    """Return the commands of a page that begin so, without their comments; those inside a line of text too."""
    text = page.read_text(encoding="utf-8")
    shown = re.findall(rf"^\$ ({start}[^\n]*)", text, re.MULTILINE) + re.findall(rf"`({start} [^`\n]*)`", text)
    return [line.split(" #")[0].strip() for line in shown]


def words_of(line: str) -> list[str]:
    """Return a command's words as a shell has them, with {a,b} taken apart."""
    words = []
    for word in shlex.split(line):
        parts = [part.split(",") for part in re.split(r"[{}]", word)]
        words += ["".join(chosen) for chosen in product(*parts)] if "{" in word else [word]
    return words


def parameters(line: str) -> dict[str, Any]:
    """Return the arguments and options that the program reads from a command line, defaults among them."""
    command: Any = typer.main.get_command(app)
    words = words_of(line)[1:]
    while hasattr(command, "commands"):
        command = command.commands[words.pop(0)]
    return dict(command.make_context(command.name, words).params)


@dataclass(frozen=True)
class Evaluated:
    """An evaluation that a command asks for, and the file that keeps what it found."""

    line: str
    policy: Path
    options: dict[str, Any]

    @property
    def stored(self) -> Path:
        suite = chosen_suite(self.options["suite"], self.options["acceptance"])
        return self.policy / saved_name(suite.own.name, suite.other_acceptance)


def evaluated() -> list[Evaluated]:
    """Return what the docs' commands evaluate; not the placeholders, suites of one's own, and other trials."""
    found = []
    for line in [line for page in PAGES for line in lines_of(page, "waypointctl eval")]:
        if any(word.isupper() for word in words_of(line)[2:]):
            continue
        options = parameters(line)
        if options["suite"] in BUILT_IN and options["trials"] is None:
            found += [Evaluated(line, policy, options) for policy in options["policies"]]
    return found


def test_every_command_gives_what_is_kept_beside_its_policy() -> None:
    assert len(evaluated()) >= 11
    for one in evaluated():
        kept, suite = read_evaluation(one.stored), chosen_suite(one.options["suite"], one.options["acceptance"])
        assert (kept.suite, kept.seed) == (suite.own.name, one.options["seed"]), one.line
        assert {case.trials for case in kept.cases} == {suite.own.trials}, one.line
        assert [case.name for case in kept.cases] == [case.name for case in suite.used.all_cases], one.line
        conditions = (kept.acceptance, kept.deadline, kept.start, kept.hold)
        walked = suite.used
        assert conditions == (walked.acceptance, walked.deadline, walked.start, walked.hold), one.line
        assert kept.policy_sha256 == load_policy(one.policy).sha256, one.line


@pytest.mark.parametrize("script", ["docs/readme_suites.py", "docs/paper_tables.py"])
def test_every_row_of_the_readmes_tables_has_its_command(script: str) -> None:
    made = runpy.run_path(str(ROOT / script))
    folder = ROOT / "policies"
    shown = (
        {folder / "ant-waypoint" / name for name in made["FILES"].values()}
        if "FILES" in made
        else {folder / name / "evaluation.json" for name in made["POLICIES"]}
    )
    given = {
        one.stored.resolve() for one in evaluated() if one.line in lines_of(ROOT / "README.md", "waypointctl eval")
    }
    assert shown <= given


def test_eval_reports_the_seed_that_a_training_reports() -> None:
    assert parameters("waypointctl eval ant-waypoint")["seed"] == EvaluationRecipe().seed


def test_the_delay_studys_command_gives_the_pages_tables() -> None:
    line = lines_of(ROOT / "docs" / "delay.md", "waypointctl study delay")[0]
    options, study = parameters(line), read_study(ROOT / "docs" / "delay-study.json")
    assert options["policy"].name == study.policy
    assert load_policy(options["policy"]).sha256 == study.policy_sha256
    assert options["find_joint_limit"] == bool(study.joint_sweep)
    assert (options["seed"], options["seeds"], options["rtt"], options["route"]) == (0, None, None, None)
    # What is not given is what --help says.
    shown: dict[str, Any] = {each.name: getattr(each, "show_default", None) for each in _study_options()}
    assert list(study.seeds) == list(range(int(shown["seeds"])))
    assert {cell.rtt_s for cell in study.cells} == set(rtts_of(shown["rtt"]))
    assert [route.name for route in study.routes] == shown["route"].split(",")
    assert {cell.autonomy for cell in study.cells} == set(options["autonomy"].split(","))


def _study_options() -> list[Any]:
    command: Any = typer.main.get_command(app)
    return list(command.commands["study"].commands["delay"].params)
