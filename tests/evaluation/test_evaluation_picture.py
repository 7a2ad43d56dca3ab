from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from tests.evaluation.found import paper_evaluation
from waypointctl.errors import InputError
from waypointctl.evaluation.evaluate import evaluate
from waypointctl.evaluation.panels import Panel, Trial, panels, refuse_too_many
from waypointctl.evaluation.picture import Regions, _draw_regions, _write_over, draw, draw_legend, legend_of, margin_in
from waypointctl.evaluation.rollout import Rollouts
from waypointctl.evaluation.suite import Case, Hold, RandomPaths, Suite, load_suite
from waypointctl.mission.fields import Acceptance
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.task.course import Deadline

FloatArray = NDArray[np.float64]

WAY = np.array([[0.0, 0.0], [2.0, 1.0], [4.0, 4.0]])
BLUE, ORANGE, PURPLE, GREEN = (0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00), (0x8E, 0x44, 0xAD), (0x00, 0x9E, 0x73)


def panel(*ends: str, group: str = "g", given: bool = True) -> Panel:
    trials = tuple(Trial(WAY[1:], WAY, end) for end in ends)  # type: ignore[arg-type] # the ends that there are
    return Panel("walker $1", "g: 1 of 2", group, (WAY[1:],) if given else (), trials)


def pixels(png: bytes) -> FloatArray:
    return np.asarray(matplotlib.image.imread(io.BytesIO(png), format="png"))[..., :3] * 255


def has(picture: FloatArray, color: tuple[int, int, int]) -> bool:
    return bool((np.abs(picture - color).max(axis=2) < 20).any())


def test_the_same_panels_are_the_same_bytes() -> None:
    drawn = [draw([panel("success", "fall")], Acceptance(), "title") for _ in range(2)]
    assert drawn[0] == drawn[1]


@pytest.mark.parametrize(("end", "color"), [("success", BLUE), ("fall", ORANGE), ("time-out", PURPLE)])
def test_each_end_has_its_colour(end: str, color: tuple[int, int, int]) -> None:
    picture = pixels(draw([panel(end)], Acceptance(), "title"))
    assert [c for c in (BLUE, ORANGE, PURPLE) if has(picture, c)] == [color]
    assert has(picture, GREEN)


def test_regions_are_of_the_acceptances_size() -> None:
    def greenish(size_m: float) -> int:
        picture = pixels(draw([panel("success")], Acceptance(shape="radius", size_m=size_m), "t"))
        return int((picture[..., 1] > picture[..., 0] + 30).sum())

    key = greenish(1e-6)  # what the key has of it
    assert (greenish(1.0) - key) / (greenish(0.5) - key) == pytest.approx(4.0, rel=0.2)


def test_the_hold_is_drawn_around_the_last_waypoint_alone() -> None:
    axes = Figure().subplots()
    _draw_regions(axes, panel("success"), Regions(Acceptance(), Hold(within_m=0.75)))
    circles = [(patch.center, patch.radius) for patch in axes.patches if isinstance(patch, Circle)]
    assert circles == [((4.0, 4.0), 0.75)]
    assert len(axes.patches) == len(WAY[1:]) + 1
    pictures = [draw([panel("success")], Acceptance(), "t", hold) for hold in (None, Hold(within_m=0.75))]
    assert pictures[0] != pictures[1]


def labels(hold: Hold | None) -> list[str]:
    return [str(handle.get_label()) for handle in legend_of([panel("success")], Regions(Acceptance(), hold))]


def test_the_key_names_the_hold_where_there_is_one() -> None:
    assert labels(None) == ["start", "acceptance region, box 0.5 m", "success"]
    assert labels(Hold(time_s=7.0))[2] == "to be held for 7 s within 0.5 m"


@pytest.mark.parametrize("width_in", [3.2, 6.1, 17.7])
def test_the_key_stays_within_the_picture(width_in: float) -> None:
    shown = panel("success", "fall", "time-out", "strayed")
    handles = legend_of([shown], Regions(Acceptance(), Hold()))
    figure = Figure(figsize=(width_in, 5.0))
    FigureCanvasAgg(figure)
    draw_legend(figure, handles, 0.5, is_sample=True)
    figure.canvas.draw()
    (legend,) = figure.legends
    box = legend.get_window_extent()
    assert 0 < box.x0 < box.x1 < width_in * figure.dpi
    assert 0 < box.y0 < box.y1 < margin_in(handles, width_in) * figure.dpi
    note = next(text for text in figure.texts if "drawn" in text.get_text())
    assert note.get_window_extent().y1 <= box.y0


def titles(name: str) -> list[str]:
    made: list[str] = []
    shown = Panel(name, "g", "g", (), panel("success").trials)

    def keep(axes: Axes, panel: Panel, letters: int) -> None:
        _write_over(axes, panel, letters)
        made.append(axes.get_title(loc="left"))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("waypointctl.evaluation.picture._write_over", keep)
        draw([shown, shown], Acceptance(), "t")
    return made


def test_of_a_long_name_the_middle_is_left_out() -> None:
    assert titles("ant-waypoint") == ["ant-waypoint"] * 2
    assert titles("/home/somebody/policies/ant-waypoint") == ["/home/somebo…ant-waypoint"] * 2


def test_whole_groups_fill_the_rows() -> None:
    groups = ["a"] * 5 + ["b"] * 2 + ["c"] * 2
    height, width, _ = pixels(draw([panel("success", group=g) for g in groups], Acceptance(), "t")).shape
    assert width / height == pytest.approx(5 / 2, rel=0.25)


def test_a_robot_that_walks_away_does_not_shrink_the_rest() -> None:
    near = panel("success")
    far = Panel("x", "g", "g", near.given, (*near.trials, Trial(WAY[1:], WAY * 1000, "time-out")))
    blue = [int((np.abs(pixels(draw([p], Acceptance(), "t")) - BLUE).max(axis=2) < 20).sum()) for p in (near, far)]
    assert blue[1] > blue[0] / 3


SUITE = Suite(
    name="s",
    acceptance=Acceptance(size_m=2.0),
    deadline=Deadline(first_s=0.2),
    cases=(Case(name="near", waypoints=((0.2, 0.0),)), Case(name="far", waypoints=((9.0, 0.0),))),
    courses=(RandomPaths(name="drawn", perimeter="legs", count=30, leg_m=(5.0, 6.0)),),
)


def test_panels_are_a_sample_of_each_case_and_what_failed(
    tmp_path: Path, make_policy: Callable[..., LoadedPolicy]
) -> None:
    rollouts: dict[str, Rollouts] = {}
    found = evaluate(
        make_policy(tmp_path / "still", gain=0.0), SUITE, 5, on_case=lambda case, new: rollouts.update({case.name: new})
    )
    near, far, drawn = panels(SUITE, [found], [rollouts])
    assert (near.subtitle, far.subtitle, drawn.subtitle) == (
        "near: success 5/5",
        "far: success 0/5",
        "drawn: success 0/5, drawn 2/5",
    )
    assert [panel.is_sample for panel in (near, far, drawn)] == [False, False, True]
    assert ({t.end for t in near.trials}, {t.end for t in far.trials}) == ({"success"}, {"time-out"})
    assert (len(near.trials), len(drawn.trials)) == (5, 2)
    assert (near.given[0].tolist(), drawn.given) == ([[0.2, 0.0]], ())


def test_the_papers_suite_has_a_panel_for_each_table_and_policy(
    tmp_path: Path, make_policy: Callable[..., LoadedPolicy]
) -> None:
    paper = load_suite("paper")
    rollouts: dict[str, Rollouts] = {}
    quick = paper.model_copy(update={"deadline": Deadline(first_s=0.02)})
    evaluate(
        make_policy(tmp_path / "s", gain=0.0), quick, 2, on_case=lambda case, new: rollouts.update({case.name: new})
    )
    found = [paper_evaluation("1", "single point", "state", 0), paper_evaluation("x", None, "egocentric", 9)]
    drawn = panels(paper, found, [rollouts, rollouts])
    assert [(p.title, p.group) for p in drawn] == [
        *(("1", "Table 1"), ("x", "Table 1"), ("x", "Table 2"), ("x", "Table 3"))
    ]
    assert [len(p.given) for p in drawn] == [1, 1, 7, 3]
    # One policy, in the paper's first table alone or in none: its table lists all cases.
    for alone in found:
        drawn = panels(paper, [alone], [rollouts])
        assert [(p.title, p.group) for p in drawn] == [(alone.policy, case.name) for case in alone.cases]
        assert [p.given[0].tolist() for p in drawn] == [[list(place) for place in case.path] for case in paper.cases]


def test_more_panels_than_a_picture_holds_are_refused() -> None:
    refuse_too_many(SUITE, 16)
    refuse_too_many(load_suite("paper"), 16)  # three tables of each
    with pytest.raises(InputError, match=r"--plot would have 51 panels, .*; a picture holds 48"):
        refuse_too_many(SUITE, 17)
