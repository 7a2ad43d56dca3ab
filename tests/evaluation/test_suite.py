from __future__ import annotations

from importlib.resources import files
from pathlib import Path

import fastjsonschema
import numpy as np
import pytest
from ruamel.yaml import YAML

from waypointctl.errors import SuiteError
from waypointctl.evaluation.suite import BUILT_IN, load_suite, suite_schema

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
    assert {case.path: case.paper for case in suite.cases} == PAPER
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
    assert (suite.acceptance.shape, suite.acceptance.size_m) == ("radius", 0.3)
    assert suite.cases[0].path == ((7.0, 12.0), (14.0, 14.5))
    assert suite.cases[0].paper is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("name: x\ncases: [{name: a, waypoints: [[1, 2]]}]\nacceptence: {}\n", ":3:1: acceptence: unknown key; did"),
        ("name: x\n", ":1:1: a suite needs 'cases', 'courses' or both"),
        (
            "name: x\ncourses: [{name: a, leg: [3 m, 2 m], perimeter: legs}]\n",
            "leg: [3.0, 2.0] is not in order: the shortest",
        ),
        (
            "name: x\ncourses: [{name: a, perimeter: legs, side: 3 m}]\n",
            "courses[0].side: is not used by 'perimeter: legs'",
        ),
        ("name: x\ncourses: [{name: a, leg_m: [1, 2]}]\n", "courses[0].leg_m: is not used by"),
        (
            "name: x\ncourses: [{name: a, perimeter: disk}]\n",
            ":2:32: courses[0].perimeter: expected one of 'square', 'disc'",
        ),
        ("name: x\ncourses: [{name: a, side: 0 m}]\n", ":2:27: courses[0].side: must be more than 0 m; got 0 m"),
        (
            "name: x\ncourses: [{name: a, count: 0}]\n",
            "courses[0].count: expected a whole number from 1 to 65536; got 0",
        ),
        ("name: x\ncourses: [{name: a}]\ncases: [{name: a, waypoints: [[1, 2]]}]\n", "used more than once: a"),
        ("name: x\ntrials: 0\ncourses: [{name: a}]\n", ":2:9: trials: expected a whole number from 1 to 100000; got 0"),
        ("name: x\nhold: {within: 0 m}\ncourses: [{name: a}]\n", ":2:16: hold.within: must be more than 0 m; got 0 m"),
        (
            "name: x\nstart: {heading: 90}\ncourses: [{name: a}]\n",
            "start.heading: 90 has no unit",
        ),
        (
            "name: x\nacceptance: {size: 3}\ncourses: [{name: a}]\n",
            "size: 3 has no unit; write 'size: 3 m' or 'size_m: 3'",
        ),
        (
            "name: x\ncourses: [{name: a}]\ntables: [{title: T, policies: [1], cases: [a]}]\n",
            "tables: 'T' names the policy 1, which 'policies' does not have",
        ),
        (
            "name: x\ncourses: [{name: a}]\npolicies: [{number: 1, training: waypoints, observation: state}]\n"
            "tables: [{title: T, policies: [1], cases: [a]}]\n",
            "tables: 'T' names the case 'a', which 'cases' does not have",
        ),
        (
            "name: x\ncases: [{name: a, waypoints: [[1, 2]]}]\n"
            "policies: [{number: 1, training: waypoints, observation: s}, "
            "{number: 2, training: waypoints, observation: t}]\ntables: [{title: T, policies: [1], cases: [a]}]\n",
            "tables: the policy 2 stands in none of them",
        ),
        ("name: x\ncases: []\n", ":2:8: cases: has 0 entries; at least 1 are needed"),
        ("name: x\ncases: [{name: a, waypoints: []}]\n", "cases[0].waypoints: has 0 entries; at least 1 are"),
        ("name: x\ncases: [{name: a, waypoints: [[1, .nan]]}]\n", ":2:35: cases[0].waypoints[0][1]: nan is not"),
        ("name: x\ncases: [{name: a, waypoints: [[1, -.inf]]}]\n", "cases[0].waypoints[0][1]: -inf is not"),
        ("name: x\ncases: [{name: a, waypoints: [[true, 1]]}]\n", "waypoints[0][0]: true is not a number"),
        ("name: x\ncases: [{name: a, waypoints: [[1]]}]\n", "cases[0].waypoints[0][1]: is missing"),
        ("name: x\ncases: [{name: a, waypoints: [[1, 2]], paper: 90}]\n", "cases[0].paper: must be at most 1; got 90"),
        (
            "name: x\ncases: [{name: a, waypoints: [[1, 2]]}, {name: a, waypoints: [[3, 4]]}]\n",
            "used more than once: a",
        ),
        (
            "name: x\nacceptance: {shape: disc}\ncases: [{name: a, waypoints: [[1, 2]]}]\n",
            "acceptance.shape: expected one of 'box' or 'radius'; got 'disc'",
        ),
        (
            "name: x\nacceptance: {size_m: 0}\ncases: [{name: a, waypoints: [[1, 2]]}]\n",
            "acceptance.size_m: must be more than 0 m; got 0 m",
        ),
        (
            "name: x\ndeadline: {first_s: -1}\ncases: [{name: a, waypoints: [[1, 2]]}]\n",
            "deadline.first_s: must be more than 0 s; got -1 s",
        ),
        (
            "name: x\ndeadline: {first_s: 1.0e+300}\ncases: [{name: a, waypoints: [[1, 2]]}]\n",
            ":2:21: deadline.first_s: must be at most 86,400 s; got 1e+300 s",
        ),
        (
            "name: x\ndeadline: {further_s: 86401}\ncases: [{name: a, waypoints: [[1, 2]]}]\n",
            ":2:23: deadline.further_s: must be at most 86,400 s; got 86401 s",
        ),
        (
            "name: x\nacceptance: {size_m: 1.0e+200}\ncases: [{name: a, waypoints: [[1, 2]]}]\n",
            ":2:22: acceptance.size_m: must be at most 100 m; got 1e+200 m",
        ),
        (
            "name: x\ncases: [{name: a, waypoints: [[1, 1.0e+200]]}]\n",
            ":2:35: cases[0].waypoints[0][1]: must be at most 10,000 m; got 1e+200 m",
        ),
        (
            "name: x\ncases: [{name: a, waypoints: [[-10001, 1]]}]\n",
            ":2:32: cases[0].waypoints[0][0]: must be at least -10,000 m; got -10001 m",
        ),
        ("cases: [{name: a, waypoints: [[1, 2]]}]\n", "required key 'name' is missing"),
        ("just text\n", "expected a mapping (key: value), found 'just text'"),
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
    with pytest.raises(
        SuiteError, match=r"papers: there is no such file\n  Give a YAML file, or .*: paper, region, anywhere, station$"
    ):
        load_suite("papers")
    with pytest.raises(SuiteError, match="is a folder, not a file"):
        load_suite(str(tmp_path))


def test_what_the_built_in_suites_say() -> None:
    region, anywhere, station = (load_suite(name) for name in ("region", "anywhere", "station"))
    ways = [
        (s.trials, s.courses[0].perimeter, s.courses[0].count, s.start.random_heading)
        for s in (region, anywhere, station)
    ]
    assert ways == [(1000, "square", 4, False), (200, "legs", 20, True), (1000, "legs", 1, True)]
    assert (region.courses[0].centre_m, region.courses[0].side_m) == ((10.0, 10.0), 10.0)
    assert anywhere.courses[0].leg_m == station.courses[0].leg_m == (1.0, 10.0)
    assert [str(s.acceptance) for s in (region, anywhere, station)] == ["box 0.5 m", "box 0.5 m", "radius 0.3 m"]
    assert (region.hold, anywhere.hold) == (None, None)
    assert station.hold is not None
    assert (station.hold.time_s, station.hold.within_m) == (10.0, 0.5)


def test_both_spellings_of_a_quantity_are_the_same_suite(tmp_path: Path) -> None:
    texts = (
        "acceptance: {shape: radius, size: 30 cm}\ndeadline: {first: 1 min, further: 0 s}\nhold: {time: 5 s}\n"
        "cases: [{name: a, waypoints: [[1 m, 200 cm]]}]\ncourses: [{name: b, side: 4 m, centre: [1 m, 2 m]}]\n",
        "acceptance: {shape: radius, size_m: 0.3}\ndeadline: {first_s: 60, further_s: 0}\nhold: {time_s: 5}\n"
        "cases: [{name: a, waypoints: [[1, 2]]}]\ncourses: [{name: b, side_m: 4, centre_m: [1, 2]}]\n",
    )
    read = []
    for number, text in enumerate(texts):
        (tmp_path / f"{number}.yaml").write_text(f"name: x\n{text}")
        read.append(load_suite(str(tmp_path / f"{number}.yaml")))
    assert read[0] == read[1]
    assert (read[0].acceptance.size_m, read[0].cases[0].path) == (0.3, ((1.0, 2.0),))


def test_the_schema_takes_the_built_in_suites_and_no_other_perimeter() -> None:
    validate = fastjsonschema.compile(suite_schema())
    suites = files("waypointctl.evaluation") / "suites"
    for name in BUILT_IN:
        validate(YAML(typ="safe").load((suites / f"{name}.yaml").read_text(encoding="utf-8")))
    with pytest.raises(fastjsonschema.JsonSchemaException, match="perimeter"):
        validate({"name": "x", "courses": [{"name": "a", "perimeter": "moon"}]})


def test_the_perimeters_of_recipes_are_those_of_suites(tmp_path: Path) -> None:
    path = tmp_path / "ring.yaml"
    path.write_text(
        "name: x\ncourses:\n"
        "  - {name: a, perimeter: ring, count: 500, centre: [3 m, 4 m], inner_radius: 1 m, radius: 2 m}\n"
    )
    drawn = load_suite(str(path)).courses[0].trial_path(0, "a", 0, (0.0, 0.0))
    radii = np.hypot(*(drawn - [3.0, 4.0]).T)
    assert drawn.shape == (500, 2)
    assert 1.0 <= radii.min() < 1.05
    assert 1.95 < radii.max() <= 2.0
