from __future__ import annotations

import io

import matplotlib.image
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tests.studies.standing import cells, line
from tests.studies.test_study_tables import study
from waypointctl.figure import BLUE as LINE
from waypointctl.studies.delay import DelayStudy, Route
from waypointctl.studies.flights import DelayFlight
from waypointctl.studies.picture import _draw_times, _places, _scale, draw

BLUE, GREEN, GOLD = (0x00, 0x72, 0xB2), (0x00, 0x9E, 0x73), (0xB8, 0x86, 0x0B)


def pixels(found: DelayStudy) -> NDArray[np.float64]:
    return np.asarray(matplotlib.image.imread(io.BytesIO(draw(found)), format="png"))[..., :3] * 255


def of(picture: NDArray[np.float64], color: tuple[int, int, int]) -> int:
    return int((np.abs(picture - color).max(axis=2) < 20).sum())


def with_cells(flown: list[DelayFlight]) -> DelayStudy:
    return study(swept=False).model_copy(update={"cells": cells(flown)})


def test_what_was_flown_has_its_colour_and_nothing_else() -> None:
    picture = pixels(study())
    assert of(picture, BLUE) > 500
    assert of(picture, GOLD) > 200
    assert of(picture, GREEN) == 0


def test_a_column_is_drawn_for_each_route_and_the_same_study_is_the_same_bytes() -> None:
    two = study().model_copy(update={"routes": (*study().routes, Route(name="$q", waypoints=1, length_m=3.0))})
    one, other = draw(two), draw(two)
    assert one == other
    wide = np.asarray(matplotlib.image.imread(io.BytesIO(one), format="png"))
    assert wide.shape[1] > 1300


def test_a_prediction_is_drawn_for_an_autonomy_that_waits() -> None:
    flown = [*line("mission", {0.0: [10.0]}), *line("short_range_goal-continuous", {40.0: [50.0]}, exchanges=5)]
    drawn = with_cells(flown)
    axes = Figure().subplots()
    _draw_times(axes, drawn, drawn.routes[0])
    assert [one.get_color() for one in axes.lines if one.get_linestyle() == "--"] == [LINE]


def test_failures_alone_can_be_drawn() -> None:
    assert of(pixels(with_cells(line("joint", {0.0: [None], 0.4: [None]}))), GOLD) > 50


def test_an_interval_that_is_wider_than_the_axis_ends_at_its_limits() -> None:
    drawn = with_cells(line("mission", {0.0: [5.0, 15.0], 10.0: [20.0, 21.0]}))  # 10 ± 64 s
    figure = Figure()
    axes = figure.subplots()
    _draw_times(axes, drawn, drawn.routes[0])
    figure.canvas.draw()
    low_s, high_s = axes.get_ylim()
    bars = [np.asarray(path.vertices)[:, 1] for one in axes.collections for path in one.get_paths()]
    assert bars
    assert all(low_s <= end <= high_s for bar in bars for end in bar)
    assert high_s < 40


rtts = st.lists(st.floats(0, 1e5).map(lambda value: round(value, 3)), min_size=1, max_size=6, unique=True)


@settings(max_examples=8, deadline=None)
@given(rtts, st.booleans())
def test_all_of_the_axis_of_round_trips_is_used_and_lines_are_straight(rtts_s: list[float], swept: bool) -> None:
    rtts_s = sorted(rtts_s)
    found = cells(line("mission", {rtt_s: [10 + rtt_s] for rtt_s in rtts_s}))
    sweep = cells(line("joint", {0.0: [9.0], 0.02: [9.5]})) if swept else ()
    drawn = study().model_copy(update={"cells": found, "joint_sweep": sweep, "joint_limits": ()})
    figure = Figure()
    axes = figure.subplots()
    _draw_times(axes, drawn, drawn.routes[0])
    _scale(axes, drawn)
    every_s = sorted([*rtts_s, *(cell.rtt_s for cell in sweep)])
    places = _places(axes, [every_s[0], every_s[-1]])
    ends = [0.5, 0.5] if every_s[0] == every_s[-1] else [0.037, 0.963]
    assert places == pytest.approx(ends, abs=0.001)
    own = [one for one in axes.lines if one.get_linestyle() == "-" and one.get_color() == LINE]
    counts = [len(np.atleast_1d(one.get_xdata())) for one in own]
    assert [count for count in counts if count > 1] == [2] * (len(rtts_s) - 1)
