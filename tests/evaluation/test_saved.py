from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from waypointctl.errors import InputError, OutputError
from waypointctl.evaluation.result import CaseResult, Evaluation, read_evaluation
from waypointctl.evaluation.saved import remove_outdated, write_evaluations
from waypointctl.mission.fields import Acceptance
from waypointctl.task.course import Deadline

CASE = CaseResult(
    name="a",
    waypoints=((1.0, 2.0),),
    trials=4,
    successes=3,
    rate=0.75,
    wilson95=(0.3, 0.95),
    falls=1,
    timeouts=0,
    mean_time_s=2.0,
    spl=0.7,
    paper=None,
)
FOUND = Evaluation(
    policy="p",
    suite="s",
    seed=1,
    cases=(CASE,),
    acceptance=Acceptance(),
    deadline=Deadline(),
    policy_sha256="0" * 64,
    versions={},
)


def test_an_evaluation_is_read_as_it_was_written(tmp_path: Path) -> None:
    write_evaluations([FOUND], tmp_path / "evaluation.json")
    assert read_evaluation(tmp_path / "evaluation.json") == FOUND
    assert [path.name for path in tmp_path.iterdir()] == ["evaluation.json"]


def test_one_of_an_earlier_version_is_read(tmp_path: Path) -> None:
    old = json.loads(FOUND.to_json())
    old = {name: old[name] for name in ("policy", "suite", "seed", "cases", "acceptance", "deadline")}
    old["cases"] = [{name: old["cases"][0][name] for name in list(old["cases"][0])[:11]}]
    (tmp_path / "old.json").write_text(json.dumps(old | {"policy_sha256": "0" * 64, "versions": {}}))
    found = read_evaluation(tmp_path / "old.json")
    assert found == FOUND
    assert (found.cases[0].orbiting, found.cases[0].late, found.cases[0].legs) == (None, None, None)


def test_several_are_a_list(tmp_path: Path) -> None:
    write_evaluations([FOUND, FOUND], tmp_path / "both.json")
    both = json.loads((tmp_path / "both.json").read_text())["evaluations"]
    assert both == [json.loads(FOUND.to_json())] * 2


def test_a_place_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"e\.json: the evaluation cannot be written: the folder .*no does not exist"):
        write_evaluations([FOUND], tmp_path / "no" / "e.json")


@pytest.mark.parametrize("text", ["{}", "[]", "not json"])
def test_what_is_no_evaluation_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "e.json").write_text(text)
    with pytest.raises(InputError, match=r"e\.json: not an evaluation: .*\n  Write it again with"):
        read_evaluation(tmp_path / "e.json")


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("cases", [], "cases: Tuple should have at least 1 item"),
        ("cases.0.trials", 0, "cases.0.trials: Input should be greater than 0"),
        ("cases.0.successes", 5, "5 successes are more than the 4 trials"),
        ("cases.0.successes", 10**400, "cases.0.successes: Input should be less than"),
        ("cases.0.rate", "NaN", "cases.0.rate: Input should be"),
        ("cases.0.legs", 0, "cases.0.legs: Input should be greater than 0"),
        ("cases.0.mean_time_s", "inf", "cases.0.mean_time_s: Input should be a finite number"),
        ("suite", "s" * 256, "suite: String should have at most 255"),
    ],
)
def test_what_no_evaluation_can_have_found_is_refused(tmp_path: Path, field: str, value: object, message: str) -> None:
    found: Any = json.loads(FOUND.to_json())
    holder, *_, last = found, *field.split(".")
    for part in field.split(".")[:-1]:
        holder = holder[int(part) if part.isdecimal() else part]
    holder[last] = value
    (tmp_path / "e.json").write_text(json.dumps(found))
    with pytest.raises(InputError, match=f"not an evaluation: .*{message}"):
        read_evaluation(tmp_path / "e.json")


def test_another_policys_evaluations_are_removed(tmp_path: Path) -> None:
    other = FOUND.model_copy(update={"policy_sha256": "1" * 64})
    write_evaluations([FOUND], tmp_path / "evaluation.json")
    write_evaluations([FOUND], tmp_path / "evaluation-region.json")
    write_evaluations([other], tmp_path / "evaluation-station.json")
    (tmp_path / "evaluation-notes.json").write_text("{}")
    remove_outdated(tmp_path, FOUND.policy_sha256)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["evaluation-notes.json", "evaluation-region.json"]
