"""Plans of the shapes that are found in public repositories: each means what was written down for it by hand."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.importers.plans import EAST_M, NORTH_M, SHAPES, At, Shape
from tests.importers.reading import Imported, imported
from waypointctl.errors import MissionError
from waypointctl.flight.executive.rules import rules_of

IMPORTED = [shape for shape in SHAPES if not shape.refused]
REFUSED = [shape for shape in SHAPES if shape.refused]


def metres(north: float, east: float) -> tuple[float, float]:
    return east * EAST_M, north * NORTH_M


def test_of_sixty_plans_at_least_fifty_five_are_imported() -> None:
    assert len(SHAPES) == len({shape.title for shape in SHAPES}) >= 60
    assert len(IMPORTED) / len(SHAPES) >= 55 / 60


@pytest.fixture(scope="module", params=IMPORTED, ids=lambda shape: shape.title)
def read(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Shape, Imported]:
    """Return a plan, and what became of it."""
    shape: Shape = request.param
    return shape, imported(tmp_path_factory.mktemp("plan"), shape.plan)


def test_a_plan_means_what_it_says(read: tuple[Shape, Imported]) -> None:
    shape, found = read
    expected = [stop if isinstance(stop, At) else At(*stop) for stop in shape.stops]
    assert len(found.all_legs) == len(expected)
    for number, (leg, stop) in enumerate(zip(found.all_legs, expected, strict=True), 1):
        assert (leg.x_m, leg.y_m) == pytest.approx(metres(stop.north, stop.east), abs=0.02)
        assert (leg.hold_s, leg.observe) == (stop.hold_s, stop.observe)
        assert (leg.acceptance, leg.tolerance_m) == (
            ("box", 0.5) if stop.radius_m is None else ("radius", stop.radius_m)
        )
        assert leg.name == (stop.name or f"WP{number}")
    assert found.mission.start.position_m == (0, 0)


def test_what_is_left_out_of_a_plan_is_named_and_counted(read: tuple[Shape, Imported]) -> None:
    shape, found = read
    assert len(found.left_out) == len(shape.left_out)
    for line, beginning in zip(found.left_out, shape.left_out, strict=True):
        assert line.startswith(beginning)
        assert f"# Left out: {line}\n" in found.text


def test_a_fence_allows_and_forbids_what_the_plans_does(read: tuple[Shape, Imported]) -> None:
    shape, found = read
    rules = rules_of(found.mission)
    assert [rules.fence.breach(*metres(*place)) for place in shape.allowed] == [""] * len(shape.allowed)
    assert all(rules.fence.breach(*metres(*place)) for place in shape.forbidden)
    assert bool(rules.fence.keep_in or rules.fence.keep_out) == bool(shape.forbidden)
    assert rules.on_breach == ("hold" if shape.home is None else "return_home")
    assert (rules.home.x_m, rules.home.y_m) == pytest.approx(metres(*(shape.home or (0, 0))), abs=0.02)


@pytest.mark.parametrize("shape", REFUSED, ids=lambda shape: shape.title)
def test_what_cannot_be_followed_is_refused_in_one_message_with_its_place(tmp_path: Path, shape: Shape) -> None:
    with pytest.raises(MissionError, match=shape.refused) as caught:
        imported(tmp_path, shape.plan)
    assert "\n" not in str(caught.value).partition("\n  ")[0]


def test_a_home_that_is_not_set_gives_way_to_an_origin(tmp_path: Path) -> None:
    (shape,) = (shape for shape in SHAPES if shape.title == "an unset home")
    found = imported(tmp_path, shape.plan, origin=(60.0, 25.0))
    assert found.legs == [(0.0, 22.28), (22.32, 22.28)]
    assert found.mission.start.position_m == (0, 0)
    assert found.left_out == ("mission.plannedHomePosition (0, 0): far from --origin; the robot starts at --origin",)
