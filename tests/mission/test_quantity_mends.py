"""What a message says to write instead can be written."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Annotated, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from waypointctl.evaluation.suite import Suite
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.mission import Mission
from waypointctl.mission.quantity import Quantity
from waypointctl.mission.yaml_source import examine
from waypointctl.training.recipe import Recipe

LENGTH: Any = Annotated[float, Quantity("m", gt=0, le=100)]


class Box(FileModel):
    size_m: LENGTH = 1.0
    corner_m: tuple[LENGTH, LENGTH] | None = None
    corners_m: tuple[LENGTH, ...] = ()


def said(source: str, model: type[BaseModel] = Box) -> list[str]:
    return [str(problem) for problem in examine(source.encode(), "f.yaml", model).problems]


def offered(problems: list[str]) -> list[str]:
    """Return what the messages say to write."""
    texts = (text for problem in problems for _, _, text in [problem.partition("; write ")])
    return [text for hint in texts for text in re.findall(r"'(\w+: [^']*)'", hint)]


@pytest.mark.parametrize(
    ("source", "hint"),
    [
        ("corner: [0 s, 2]", "write 'corner: [2 m, 2 m]'"),
        ("corner: [3 s, 2]", "write 'corner: [3 m, 2 m]'"),
        ("corner: [2, 3 ft]", "write 'corner: [2 m, 3 m]'"),
        ("corner: [2, wide]", "write 'corner: [2 m, 2 m]'"),
        ("corner: [-2, wide]", "write 'corner: [1 m, 1 m]'"),
        ("corner: [2, true]", "write 'corner: [2 m, 2 m]'"),
        ("corner: [2]", "write 'corner: [2 m, 2 m]'"),
        ("corner: [2, 3]", "write 'corner: [2 m, 3 m]' or 'corner_m: [2, 3]'"),
        ("corner: [2, 300]", "write 'corner: [2 m, 300 cm]'"),
        ("corner: [2, 30 cm]", "write 'corner: [2 m, 30 cm]'"),
        ("corners: [1, .nan, 3]", "write 'corners: [1 m, 1 m, 3 m]'"),
        ("size: -5", "write 'size: 1 m' or 'size_m: 1'"),
        ("size: .nan", "write 'size: 1 m' or 'size_m: 1'"),
    ],
)
def test_a_neighbours_mistake_is_not_part_of_the_advice(source: str, hint: str) -> None:
    (problem,) = (problem for problem in said(source) if "has no unit" in problem)
    assert problem.endswith(f"; {hint}")
    assert all(not said(text) for text in offered([problem]))


ENTRY = st.sampled_from(
    ["1", "2.5", "-3", "0", "1e999", "101", ".nan", "1 m", "' 20cm '", "0 s", "5 ft", "-2 ft", "0 m", "1e400 m", "wide",
     "true", "null", "[1]", "{a: 1}", "'1'", "10 km"]
)  # fmt: skip


@given(st.sampled_from(["corner", "corners", "size"]), st.lists(ENTRY, max_size=4))
def test_whatever_is_wrong_what_is_offered_is_right(field: str, entries: list[str]) -> None:
    for source in (f"{field}: [{', '.join(entries)}]", *(f"{field}: {entry}" for entry in entries)):
        for text in offered(said(source)):
            assert said(text) == [], (source, text)


@pytest.mark.parametrize("model", [Mission, Recipe, Suite])
def test_a_one_that_is_offered_where_nothing_else_is_known_fits_every_quantity(model: type[BaseModel]) -> None:
    found = list(quantities(model, set()))
    assert len(found) >= 5
    assert all(quantity.fits(1) for quantity in found)


def quantities(part: Any, seen: set[int]) -> Iterator[Quantity]:
    """Yield every quantity in the fields of a model, and of the models in those."""
    if isinstance(part, Quantity):
        yield part
    elif isinstance(part, type) and issubclass(part, BaseModel):
        if id(part) not in seen:
            seen.add(id(part))
            for field in part.model_fields.values():
                for inner in (field.annotation, *field.metadata):
                    yield from quantities(inner, seen)
    else:
        for inner in (*getattr(part, "__args__", ()), *getattr(part, "__metadata__", ())):
            yield from quantities(inner, seen)
