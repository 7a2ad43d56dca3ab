from __future__ import annotations

from pathlib import Path

import pytest

from tests.studies.standing import flight
from waypointctl.errors import InputError, OutputError
from waypointctl.studies.case import DelayCase, grid
from waypointctl.studies.results_file import RESULTS, ResultsFile, StudyInputs

INPUTS = StudyInputs(policy="p", policy_sha256="0" * 64, think_s=0.0, source="abc", routes={"r": "1"})
CASES = grid(["r"], ["mission", "waypoint"], [0.0, 0.4], range(2))
FLOWN = [flight(case, 10.0 + case.rtt_s + case.seed / 3) for case in CASES]


def written(folder: Path, inputs: StudyInputs = INPUTS) -> dict[DelayCase, object]:
    with ResultsFile.held(folder, inputs) as results:
        return dict(results.flown)


def test_what_was_added_is_there_again(tmp_path: Path) -> None:
    with ResultsFile.held(tmp_path / "new" / "study", INPUTS) as results:
        for one in FLOWN:
            results.add(one)
    assert written(tmp_path / "new" / "study") == dict(zip(CASES, FLOWN, strict=True))


@pytest.mark.parametrize("kept", [1, 20, 190])
def test_a_torn_line_is_dropped_wherever_it_was_torn(tmp_path: Path, kept: int) -> None:
    with ResultsFile.held(tmp_path, INPUTS) as results:
        for one in FLOWN[:3]:
            results.add(one)
    path = tmp_path / RESULTS
    whole, last = path.read_bytes()[:-1].rsplit(b"\n", 1)
    path.write_bytes(whole + b"\n" + last[:kept])
    assert list(written(tmp_path)) == CASES[:2]
    with ResultsFile.held(tmp_path, INPUTS) as results:
        results.add(FLOWN[2])
    assert list(written(tmp_path)) == CASES[:3]


def test_a_file_torn_in_its_first_line_begins_again(tmp_path: Path) -> None:
    (tmp_path / RESULTS).write_bytes(b'{"policy":"p","poli')
    assert written(tmp_path) == {}


def test_the_order_of_ending_leaves_no_trace(tmp_path: Path) -> None:
    for name, order in (("a", FLOWN), ("b", FLOWN[::-1])):
        with ResultsFile.held(tmp_path / name, INPUTS) as results:
            for one in order:
                results.add(one)
            results.write_in_order(CASES)
    assert (tmp_path / "a" / RESULTS).read_bytes() == (tmp_path / "b" / RESULTS).read_bytes()


@pytest.mark.parametrize(
    ("changed", "problem"),
    [
        ({"policy_sha256": "1" * 64}, "another policy"),
        ({"think_s": 1.0}, "another think time"),
        ({"source": "abd"}, "another version of waypointctl"),
        ({"routes": {"r": "2"}}, "another route 'r'"),
    ],
)
def test_flights_of_another_study_are_not_mixed_in(tmp_path: Path, changed: dict[str, object], problem: str) -> None:
    with ResultsFile.held(tmp_path, INPUTS) as results:
        results.add(FLOWN[0])
    before = (tmp_path / RESULTS).read_bytes()
    with pytest.raises(InputError, match=f"{RESULTS}: was made with {problem}\n  Give another --out"):
        written(tmp_path, INPUTS.model_copy(update=changed))
    assert (tmp_path / RESULTS).read_bytes() == before


def test_another_route_is_taken_in(tmp_path: Path) -> None:
    written(tmp_path)
    both = {"q": "3", "r": "1"}
    written(tmp_path, INPUTS.model_copy(update={"routes": {"q": "3"}}))
    first, *_ = (tmp_path / RESULTS).read_bytes().splitlines()
    assert StudyInputs.model_validate_json(first).routes == both


def test_what_is_no_study_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / RESULTS).write_bytes(b"diary\n")
    with pytest.raises(InputError, match=f"{RESULTS}:1: not the flights of a study"):
        written(tmp_path)
    assert (tmp_path / RESULTS).read_bytes() == b"diary\n"


def test_two_studies_do_not_write_one_folder(tmp_path: Path) -> None:
    with (
        ResultsFile.held(tmp_path, INPUTS),
        pytest.raises(OutputError, match="another study is writing here"),
        ResultsFile.held(tmp_path, INPUTS),
    ):
        pass
