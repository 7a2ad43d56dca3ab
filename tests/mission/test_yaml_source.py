"""The reading of any model, with models that are not the mission."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field, create_model

from waypointctl.errors import RecipeError
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity
from waypointctl.mission.yaml_source import as_error, examine, read_model, read_source

LENGTH: Any = Annotated[float, Quantity("m")]


class Plain(BaseModel):
    model_config = ConfigDict(extra="forbid")

    rate: float = Field(gt=0)
    kind: Literal["a", "b"] = "a"


class Outer(BaseModel):
    """Models in every kind of container, none of them a FileModel."""

    model_config = ConfigDict(extra="forbid")

    one: Plain | None = None
    many: list[Plain] = []
    named: dict[str, Plain] = {}


class Shape(FileModel):
    size_m: Annotated[float, Quantity("m", gt=0)]
    corner_m: tuple[Annotated[float, Quantity("m")], Annotated[float, Quantity("m")]] = (0.0, 0.0)
    spread_rad: Annotated[float, Quantity("rad", ge=0, le=1)] = 0.0
    slope: float = 0.0  # no unit in its name, so no bare name either


def problems(source: str, model: type[BaseModel]) -> list[str]:
    return [str(problem) for problem in examine(source.encode(), "f.yaml", model).problems]


def test_a_good_file_becomes_the_model() -> None:
    outer = read_model(b"one: {rate: 2}\nmany: [{rate: 1, kind: b}]", "f.yaml", Outer, RecipeError)
    assert outer == Outer(one=Plain(rate=2), many=[Plain(rate=1, kind="b")])


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("one: {rate: -1}", "f.yaml:1:13: one.rate: must be more than 0; got -1"),
        ("one: {rat: 1, rate: 1}", "f.yaml:1:7: one.rat: unknown key; did you mean 'rate'?"),
        ("many:\n- rate: 1\n- kind: b", "f.yaml:3:3: many[1]: required key 'rate' is missing"),
        ("named: {x y: {kind: c, rate: 1}}", "f.yaml:1:21: named.'x y'.kind: expected one of 'a' or 'b'; got 'c'"),
        ("named: {x: {kin: c, rate: 1}}", "f.yaml:1:13: named.x.kin: unknown key; did you mean 'kind'?"),
        ("zzz: 1", "f.yaml:1:1: zzz: unknown key; allowed are one, many, named"),
        ("- 1", "f.yaml:1:1: expected a mapping (key: value), found a list"),
        ("just words", "f.yaml:1:1: expected a mapping (key: value), found 'just words'"),
        ("many: 5", "f.yaml:1:7: many: 5 is not a list"),
        ("one:\n  rate:", "f.yaml:2:8: one.rate: null is not a number"),
    ],
)
def test_any_model_gets_its_problems_placed(source: str, problem: str) -> None:
    assert problems(source, Outer) == [problem]


def test_all_problems_are_listed_in_the_order_of_the_file() -> None:
    source = "named: {x: {rate: 0}}\nmany: [{}]\nnamed: {}\none: {rate: .nan, kind: 3}"
    assert problems(source, Outer) == [
        "f.yaml:1:19: named.x.rate: must be more than 0; got 0",
        "f.yaml:2:8: many[0]: required key 'rate' is missing",
        "f.yaml:3:1: named: duplicate key, first in line 1",
        "f.yaml:4:13: one.rate: must be more than 0; got nan",
        "f.yaml:4:25: one.kind: expected one of 'a' or 'b'; got 3",
    ]


def test_the_error_is_of_the_type_asked_for_and_lists_everything() -> None:
    with pytest.raises(RecipeError) as caught:
        read_model(b"one: {rate: -1}\nmany: 5", "r.yaml", Outer, RecipeError)
    assert str(caught.value).splitlines() == [
        "r.yaml: 2 problems",
        "r.yaml:1:13: one.rate: must be more than 0; got -1",
        "r.yaml:2:7: many: 5 is not a list",
    ]


def test_a_single_problem_needs_no_heading() -> None:
    reading = examine(b"many: 5", "r.yaml", Outer)
    error = as_error(reading.problems, RecipeError)
    assert (error.where, error.problem) == ("r.yaml:1:7", "many: 5 is not a list")
    assert str(error) == "r.yaml:1:7: many: 5 is not a list"


@pytest.mark.parametrize(
    "source", ["size_m: 1.5", "size: 1.5 m", "size: 150 cm", "{size: '0.0015km', corner_m: [0, 0]}"]
)
def test_a_quantity_has_two_spellings(source: str) -> None:
    assert read_model(source.encode(), "s", Shape, RecipeError) == Shape(size_m=1.5)


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("size: 2", "1:7: size: 2 has no unit; write 'size: 2 m' or 'size_m: 2'"),
        ("size: 2 ft", "1:7: size: '2 ft' has the unit 'ft'; allowed are mm, cm, m, km"),
        ("size: big", "1:7: size: 'big' is not a number with a unit (mm, cm, m, km)"),
        ("size:", "1:6: size: null is not a number with its unit; write 'size: 1 m' or 'size_m: 1'"),
        ("size: true", "1:7: size: true is not a number with its unit; write 'size: 1 m' or 'size_m: 1'"),
        ("size: [1 m]", "1:7: size: a list of 1 is not a number with its unit; write 'size: 1 m' or 'size_m: 1'"),
        ("size: -20 cm", "1:7: size: must be more than 0 m; got -20 cm"),
        ("size: 1e400 m", "1:7: size: '1e400 m' is not a finite number"),
        ("size: 1e-99999999999999999999 m", "1:7: size: must be more than 0 m; got 1e-99999999999999999999 m"),
        ("{size: 1 m, spread: 90 deg}", "1:21: spread: must be at most 1 rad; got 90 deg"),
        ("size_m: 2 m", "1:9: size_m: '2 m' is not a number; write 'size: 1 m' or 'size_m: 1'"),
        ("size_m: true", "1:9: size_m: true is not a number; write 'size: 1 m' or 'size_m: 1'"),
        ("size_m: .inf", "1:9: size_m: inf is not a finite number"),
        ("{size: 2 m, size_m: 2}", "1:21: size_m: is given as 'size' and as 'size_m': keep one"),
        (
            "{size: 2 m, corner: [1, 2]}",
            "1:22: corner[0]: 1 has no unit; write 'corner: [1 m, 2 m]' or 'corner_m: [1, 2]'",
        ),
        ("{size: 2 m, corner: [1 m]}", "1:21: corner[1]: is missing"),
        ("{size: 2 m, corner: 1 m}", "1:21: corner: '1 m' is not a list"),
        ("{size: 2 m, slop: 1}", "1:13: slop: unknown key; did you mean 'slope'?"),
        (
            "{size: 2 m, sise: 1}",
            "1:13: sise: unknown key; did you mean 'size_m' (a number in m) or 'size' (with its unit: mm, cm, m, km)?",
        ),
        ("slope: 3", "1:1: required key 'size' is missing; write 'size: ...' with a unit, or 'size_m: ...' in m"),
    ],
)
def test_a_quantity_written_wrongly_says_how_to_mend_it(source: str, problem: str) -> None:
    assert problems(source, Shape) == [f"f.yaml:{problem}"]


def test_an_angle_in_radians_is_read_in_either_unit() -> None:
    assert read_model(b"{size: 1 m, spread: 0.1 rad}", "s", Shape, RecipeError).spread_rad == 0.1
    assert read_model(b"{size: 1 m, spread: 45 deg}", "s", Shape, RecipeError).spread_rad == pytest.approx(0.7853981634)


@pytest.mark.parametrize("field", [LENGTH, tuple[LENGTH, LENGTH], LENGTH | None])
def test_a_quantity_is_in_the_unit_that_its_name_ends_in(field: Any) -> None:
    create_model("Right", __base__=FileModel, long_m=(field, ...))
    for name in ("long_s", "long", "longm"):
        fields: dict[str, Any] = {name: (field, ...)}
        with pytest.raises(TypeError, match=rf"Wrong\.{name} is in m: its name has to end in that"):
            create_model("Wrong", __base__=FileModel, **fields)


def test_a_quantity_in_an_unknown_unit_is_refused() -> None:
    with pytest.raises(ValueError, match="'ft' is not a unit that a name ends in: s, m, deg, rad, hz"):
        Quantity("ft")


def test_a_field_without_its_unit_in_the_name_takes_numbers() -> None:
    assert read_model(b"{size: 1 m, slope: 30}", "s", Shape, RecipeError).slope == 30.0


def test_long_values_are_cut() -> None:
    (line,) = problems(f"one: {{rate: 1, kind: {'x' * 5000}}}", Outer)
    assert len(line) < 150


def test_reads_a_file(tmp_path: Path) -> None:
    (tmp_path / "f.yaml").write_bytes(b"a: 1\r\n")
    assert read_source(tmp_path / "f.yaml", RecipeError) == b"a: 1\r\n"


def test_a_file_that_cannot_be_read_says_why(tmp_path: Path) -> None:
    cases = {tmp_path / "none.yaml": "there is no such file", tmp_path: "is a folder", Path("\0"): "cannot be read"}
    for path, text in cases.items():
        with pytest.raises(RecipeError, match=text) as caught:
            read_source(path, RecipeError)
        assert caught.value.where == str(path)


def test_a_huge_file_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "huge.yaml").write_bytes(b"#" * (1 << 21))
    with pytest.raises(RecipeError, match="is larger than the 1 MiB that are read"):
        read_source(tmp_path / "huge.yaml", RecipeError)
