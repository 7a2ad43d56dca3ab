from __future__ import annotations

from pathlib import Path

import pytest

from waypointctl.errors import SuiteError
from waypointctl.evaluation.suite import load_suite

PAPER = {  # Tables 1 to 3, policy 5
    ((10, 10),): 1.0,
    ((14, 14),): 0.7,
    ((12, 8),): 0.7,
    ((8, 12),): 0.8,
    ((13, 7),): 0.3,
    ((7, 13),): 0.5,
    ((6, 6),): 0.8,
    ((7, 7), (14, 14)): 0.8,
    ((7, 12), (14, 14)): 0.9,
    ((12, 7), (14, 14)): 0.0,
}


def refusal(path: Path, text: str) -> str:
    path.write_text(text)
    with pytest.raises(SuiteError) as caught:
        load_suite(str(path))
    return str(caught.value)


def test_the_papers_suite_is_the_papers_tables() -> None:
    suite = load_suite("paper")
    assert {case.waypoints: case.paper for case in suite.cases} == PAPER
    assert len({case.name for case in suite.cases}) == 10
    assert (suite.acceptance.shape, suite.acceptance.size_m) == ("box", 0.5)
    assert (suite.deadline.first_s, suite.deadline.further_s) == (10, 20)


def test_a_file_of_the_documented_shape_is_read(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(
        "name: my-suite\n"
        "acceptance: {shape: radius, size_m: 0.3}\n"
        "cases:\n"
        "  - {name: dogleg, waypoints: [[7, 12], [14, 14.5]]}\n"
    )
    suite = load_suite(str(path))
    assert suite.name == "my-suite"
    assert (suite.acceptance.to_task().shape, suite.acceptance.to_task().size_m) == ("radius", 0.3)
    assert suite.cases[0].waypoints == ((7.0, 12.0), (14.0, 14.5))
    assert suite.cases[0].paper is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name: x\ncases: [{name: a, waypoints: [[1, 2]]}]\nacceptence: {}\n", ":3:1: acceptence: unknown key; did"),
        ("name: x\ncases: []\n", ":2:8: cases: a suite needs at least one case"),
        ("name: x\ncases: [{name: a, waypoints: []}]\n", "cases[0].waypoints: a path needs at least one waypoint"),
        ("name: x\ncases: [{name: a, waypoints: [[1, .nan]]}]\n", ":2:35: cases[0].waypoints[0][1]: nan is not"),
        ("name: x\ncases: [{name: a, waypoints: [[1, -.inf]]}]\n", "cases[0].waypoints[0][1]: -inf is not"),
        ("name: x\ncases: [{name: a, waypoints: [[true, 1]]}]\n", "waypoints[0][0]: true is not a number"),
        ("name: x\ncases: [{name: a, waypoints: [[1]]}]\n", "cases[0].waypoints[0][1]: is missing"),
        ("name: x\ncases: [{name: a, waypoints: [[1, 2]], paper: 90}]\n", "cases[0].paper: 90 is not <= 1"),
        ("name: x\ncases: [{name: a, waypoints: [[1, 2]]}, {name: a, waypoints: [[3, 4]]}]\n", "called a"),
        ("name: x\nacceptance: {shape: disc}\ncases: [{name: a, waypoints: [[1, 2]]}]\n", "acceptance.shape: 'disc'"),
        (
            "name: x\nacceptance: {size_m: 0}\ncases: [{name: a, waypoints: [[1, 2]]}]\n",
            "acceptance.size_m: 0 is not > 0",
        ),
        ("name: x\ndeadline: {first_s: -1}\ncases: [{name: a, waypoints: [[1, 2]]}]\n", "deadline.first_s: -1 is not"),
        (
            "name: x\ndeadline: {first_s: 1.0e+300}\ncases: [{name: a, waypoints: [[1, 2]]}]\n",
            ":2:21: deadline.first_s: 1e+300 is not <= 86400",
        ),
        (
            "name: x\ndeadline: {further_s: 86401}\ncases: [{name: a, waypoints: [[1, 2]]}]\n",
            ":2:23: deadline.further_s: 86401 is not <= 86400",
        ),
        (
            "name: x\nacceptance: {size_m: 1.0e+200}\ncases: [{name: a, waypoints: [[1, 2]]}]\n",
            ":2:22: acceptance.size_m: 1e+200 is not <= 100",
        ),
        ("name: x\ncases: [{name: a, waypoints: [[1, 1.0e+200]]}]\n", ":2:35: cases[0].waypoints[0][1]: 1e+200 is not"),
        ("name: x\ncases: [{name: a, waypoints: [[-10001, 1]]}]\n", ":2:32: cases[0].waypoints[0][0]: -10001 is not"),
        ("cases: [{name: a, waypoints: [[1, 2]]}]\n", "name: is missing"),
        ("just text\n", "is not a mapping"),
        ("", ""),
        ("name: [x\n", ":2:1: "),
    ],
)
def test_what_is_no_suite_is_refused_with_its_place(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "mine.yaml"
    found = refusal(path, text)
    assert found.startswith(str(path))
    assert message in found


def test_one_bad_number_is_one_problem(tmp_path: Path) -> None:
    text = "name: x\ncases: [{name: a, waypoints: [[1, .nan]]}, {name: b, waypoints: [[1, 2]]}]\n"
    assert "\n" not in refusal(tmp_path / "mine.yaml", text)


def test_a_suite_that_is_not_there_is_refused_with_those_that_are(tmp_path: Path) -> None:
    with pytest.raises(SuiteError, match=r"papers: there is no such file\n  give a YAML file, or .*: paper$"):
        load_suite("papers")
    with pytest.raises(SuiteError, match="is a folder, not a file"):
        load_suite(str(tmp_path))
