from __future__ import annotations

from pathlib import Path
from typing import Any

import fastjsonschema
import numpy as np
import pytest

from tests.training.tiny import RECIPE, tiny_recipe
from waypointctl.errors import RecipeError
from waypointctl.mission.yaml_tree import read_tree
from waypointctl.task.config import FailureReplay
from waypointctl.task.course import PERIMETERS, Course
from waypointctl.training.recipe import Recipe
from waypointctl.training.recipe_file import recipe_schema

COURSE = "{perimeter: legs, count: 2, leg: [0.6 m, 1 m]}"  # as RECIPE has it


def listed(cases: list[object]) -> Course:
    return Course.model_validate({"cases": cases})


RIGHT: list[tuple[str, Course]] = [
    ("{}", Course()),
    ("{min_distance: 2.5 m}", Course(min_distance_m=2.5)),
    ("{perimeter: disc, radius: 3 m, centre: [1 m, 2 m]}", Course(perimeter="disc", centre_m=(1.0, 2.0), radius_m=3.0)),
    (
        "{perimeter: ring, count: 7, radius_m: 3, inner_radius: 150 cm, min_distance_m: 1}",
        Course(perimeter="ring", count=7, radius_m=3.0, inner_radius_m=1.5, min_distance_m=1.0),
    ),
    ("{perimeter: legs, leg: [2 m, 3 m]}", Course(perimeter="legs", leg_m=(2.0, 3.0))),
    ("{cases: [[[10, 10]]]}", listed([[[10.0, 10.0]]])),
    ("{cases: [[[10 m, 10 m]]]}", listed([[[10.0, 10.0]]])),
    (
        "{cases: [[[7, 12], {position: [14 m, 14 m]}], {waypoints: [[10, 10]], weight: 2.5}]}",
        listed([[[7.0, 12.0], [14.0, 14.0]], {"waypoints": [[10.0, 10.0]], "weight": 2.5}]),
    ),
]

# What stands in place of COURSE, and the message about it, from the column on.
WRONG = [
    ("{perimeter: circle}", "21: course.perimeter: expected one of 'square', 'disc', 'ring' or 'legs'; got 'circle'"),
    (
        "{perimeter: disc, side: 5 m}",
        "33: course.side: is not used by 'perimeter: disc', which takes count, centre, radius and min_distance",
    ),
    ("{radius_m: 3}", "20: course.radius_m: is not used by 'perimeter: square', which takes"),
    ("{perimeter: legs, min_distance: 3 m}", "41: course.min_distance: is not used by 'perimeter: legs'"),
    ("{perimeter: ring, radius: 3 m}", "21: course.perimeter: a ring also needs 'inner_radius'"),
    (
        "{perimeter: ring, radius: 3 m, inner_radius: 4 m}",
        "54: course.inner_radius: 4 m is not less than the radius of 3 m",
    ),
    (
        "{perimeter: ring, radius: 3 m, inner_radius: 4 m, min_distance: 9 m}",
        "54: course.inner_radius: 4 m is not less than the radius of 3 m",
    ),
    ("{perimeter: disc, radius: 3}", "35: course.radius: 3 has no unit; write 'radius: 3 m' or 'radius_m: 3'"),
    (
        "{side: 4 m, min_distance: 3 m}",
        "35: course.min_distance: 3 m is not from 0 to 2 m (half its side), the most in this region",
    ),
    ("{min_distance: -1 m}", "24: course.min_distance: must be at least 0 m; got -1 m"),
    ("{cases: []}", "17: course.cases: has 0 entries; at least 1 are needed"),
    ("{cases: [[]]}", "18: course.cases[0]: has 0 entries; at least 1 are needed"),
    ("{cases: [[10, 10]]}", "17: course.cases: each case is a list of waypoints, and each waypoint [x, y]: cases: [[["),
    ("{cases: [10 m, 10 m]}", "17: course.cases: each case is a list of waypoints, and each waypoint [x, y]"),
    ("{cases: [[[10, 10, 3]]]}", "19: course.cases[0][0]: at most 2 entries are allowed; found 3"),
    ("{cases: [[[10 s, 10 m]]]}", "20: course.cases[0][0][0]: '10 s' has the unit 's'; allowed are mm, cm, m, km"),
    ("{cases: [{waypoints: [[1, 1]], weight: 0}]}", "48: course.cases[0].weight: must be more than 0; got 0"),
    (
        "{cases: [[[10, 10]]], count: 2}",
        "38: course.count: cannot be used with 'cases', which are the courses themselves: keep one of the two",
    ),
]


def with_course(course: str) -> str:
    assert RECIPE.count(COURSE) == 1
    return RECIPE.replace(COURSE, course)


def recipe_of(folder: Path, course: str) -> Recipe:
    return tiny_recipe(folder, with_course(course)).recipe


@pytest.mark.parametrize(("text", "course"), RIGHT, ids=[text for text, _ in RIGHT])
def test_what_is_written_is_what_is_drawn(tmp_path: Path, text: str, course: Course) -> None:
    task = recipe_of(tmp_path, text).task(0)
    assert task.course == course
    assert task.failure_replay == FailureReplay(), "nothing is repeated by default"
    fastjsonschema.compile(recipe_schema())(read_tree(with_course(text).encode()).data)


@pytest.mark.parametrize(("text", "message"), WRONG, ids=[text for text, _ in WRONG])
def test_what_is_wrong_is_said_with_its_place(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(RecipeError) as caught:
        recipe_of(tmp_path, text)
    assert str(caught.value).startswith(f"{tmp_path}/recipe.yaml:3:{message}")


def test_all_that_means_nothing_is_said_at_once(tmp_path: Path) -> None:
    with pytest.raises(RecipeError, match=r"2 problems\n.*:37: course\.side: .*\n.*:47: course\.leg: "):
        recipe_of(tmp_path, "{cases: [[[10, 10]]], side: 4 m, leg: [1 m, 2 m]}")


def replaying(folder: Path, text: str) -> Recipe:
    return recipe_of(folder, f"{COURSE}\nfailure_replay: {text}")


def test_failed_courses_are_repeated_as_the_recipe_says(tmp_path: Path) -> None:
    expected = FailureReplay(probability=0.3, memory=8, tries=5)
    assert replaying(tmp_path, "{probability: 0.3}").task(1).failure_replay == expected
    text = "{probability: 0.2, memory: 3, tries: 1}"
    assert replaying(tmp_path, text).task(0).failure_replay == FailureReplay(probability=0.2, memory=3, tries=1)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{probability: 1.3}", "4:31: failure_replay.probability: must be at most 1; got 1.3"),
        ("{tries: 2}", "4:25: failure_replay.tries: needs a 'probability' above 0"),
        ("{probability: 0.3, memory: 0}", "4:44: failure_replay.memory: expected a whole number from 1 to 256; got 0"),
    ],
)
def test_what_is_wrong_with_a_replay_is_said_with_its_place(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(RecipeError) as caught:
        replaying(tmp_path, text)
    assert str(caught.value).startswith(f"{tmp_path}/recipe.yaml:{message}")


@pytest.mark.parametrize("perimeter", PERIMETERS)
def test_a_recipe_draws_what_its_perimeter_says(tmp_path: Path, perimeter: str) -> None:
    sizes = {"disc": ", radius: 3 m", "ring": ", radius: 3 m, inner_radius: 2 m"}.get(perimeter, "")
    course = recipe_of(tmp_path, f"{{perimeter: {perimeter}{sizes}}}").task(0).course
    rng, start = np.random.default_rng(0), np.array([1.0, 1.0])
    drawn = np.concatenate([course.draw(rng, start) for _ in range(200)])
    radius = np.hypot(*(drawn - 10.0).T)
    low, high = {"square": (0, 2.5 * np.sqrt(2)), "disc": (0, 3), "ring": (2, 3)}.get(perimeter, (0, np.inf))
    assert low <= radius.min()
    assert radius.max() <= high
    assert radius.max() > 2.9
    assert (radius < 2).any() == (perimeter != "ring")


def test_the_schema_tells_editors_what_every_field_of_a_course_is() -> None:
    schema = recipe_schema()
    course = resolved(schema, schema["properties"]["course"])
    names = ("perimeter", "radius", "inner_radius_m", "min_distance", "cases")
    for name in names:
        assert course["properties"][name]["description"]
    assert course["properties"]["perimeter"]["enum"] == list(PERIMETERS)
    check = fastjsonschema.compile(schema)
    for wrong in ("{min_distance: 3}", "{cases: [[[1, 2, 3]]]}", "{cases: []}", "{radius: 0 s}"):
        with pytest.raises(fastjsonschema.JsonSchemaException):
            check(read_tree(with_course(wrong).encode()).data)


def resolved(schema: dict[str, Any], part: dict[str, Any]) -> dict[str, Any]:
    """Return the definition that a part of a schema refers to."""
    reference = part.get("$ref") or part["allOf"][0]["$ref"]
    found = schema["$defs"][reference.rpartition("/")[2]]
    assert isinstance(found, dict)
    return found
