from __future__ import annotations

import io

import matplotlib.image
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.study.standing import cells, line
from tests.study.test_study_tables import study
from waypointctl.study.delay import DelayStudy, Route
from waypointctl.study.measure import Flown
from waypointctl.study.picture import draw

BLUE, GREEN, GOLD = (0x00, 0x72, 0xB2), (0x00, 0x9E, 0x73), (0xB8, 0x86, 0x0B)


def pixels(found: DelayStudy) -> NDArray[np.float64]:
    return np.asarray(matplotlib.image.imread(io.BytesIO(draw(found)), format="png"))[..., :3] * 255


def of(picture: NDArray[np.float64], color: tuple[int, int, int]) -> int:
    return int((np.abs(picture - color).max(axis=2) < 20).sum())


def with_cells(flown: list[Flown]) -> DelayStudy:
    return study(swept=False).model_copy(update={"cells": cells(flown)})


def test_the_same_study_is_the_same_bytes() -> None:
    assert draw(study()) == draw(study())


def test_what_was_flown_has_its_colour_and_nothing_else() -> None:
    picture = pixels(study())
    assert of(picture, BLUE) > 500
    assert of(picture, GOLD) > 200
    assert of(picture, GREEN) == 0


def test_a_column_is_drawn_for_each_route() -> None:
    two = study().model_copy(update={"routes": (*study().routes, Route(name="$q", waypoints=1, length_m=3.0))})
    assert pixels(two).shape[1] > 1.8 * pixels(study()).shape[1]


@pytest.mark.parametrize(("autonomy", "has_one"), [("mission", True), ("heading-continuous", False)])
def test_a_prediction_is_drawn_for_who_waits(autonomy: str, has_one: bool) -> None:
    """How many commands were waited for shows in the prediction, and nowhere else."""
    base = line("mission", {0.0: [10.0]})
    drawn = [draw(with_cells([*base, *line(autonomy, {40.0: [50.0]}, exchanges=n)])) for n in (1, 5)]
    assert (drawn[0] != drawn[1]) == has_one


@pytest.mark.parametrize("times_s", [[None], [None, 10.0, None]])
def test_failures_alone_can_be_drawn(times_s: list[float | None]) -> None:
    assert of(pixels(with_cells(line("joint", {0.0: times_s, 0.4: [None]}))), GOLD) > 50
