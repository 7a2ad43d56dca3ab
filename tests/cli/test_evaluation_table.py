"""An evaluation as a table: no number of it is cut, however narrow the terminal."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from waypointctl.cli.tui.tables import GridView
from waypointctl.evaluation.result import CaseResult, Evaluation
from waypointctl.evaluation.tables import results_grid
from waypointctl.mission.fields import Acceptance
from waypointctl.task.course import Deadline

NUMBERS = ("100/100", "100.0%", "96.3-100.0", "97%", "112.35", "0.987")


def shown(width: int, name: str = "to-6-6") -> str:
    case = CaseResult(
        name=name,
        waypoints=((6.0, 6.0), (-6.0, 6.0), (-6.0, -6.0), (6.0, -6.0)),
        trials=100,
        successes=100,
        rate=1.0,
        wilson95=(0.963, 1.0),
        falls=0,
        timeouts=0,
        mean_time_s=112.35,
        spl=0.987,
        paper=0.97,
    )
    evaluation = Evaluation.model_construct(
        policy="walker",
        suite="paper",
        seed=7,
        cases=(case,),
        acceptance=Acceptance(),
        deadline=Deadline(),
        policy_sha256="",
        versions={},
    )
    out = Console(file=io.StringIO(), width=width)
    with out.capture() as capture:
        out.print(GridView(results_grid([evaluation]), ("runs/walker/evaluation.json",)))
    text = capture.get()
    assert max(map(len, text.splitlines())) <= width
    assert "…" not in text
    return text


@pytest.mark.parametrize("name", ["to-6-6", "a-name-" * 8])
def test_80_columns_hold_every_number_whole(name: str) -> None:
    table, _, left_out = shown(80, name).partition("left out: ")
    assert "waypoints" not in table
    assert left_out.startswith("waypoints [m]")
    text = table
    for part in ("success", "rate", "paper", "falls", *NUMBERS[:4]):
        assert part in text, part


def test_80_columns_hold_all_but_the_waypoints_of_a_short_name() -> None:
    assert [part for part in NUMBERS if part not in shown(80)] == []


def test_a_wide_terminal_has_the_waypoints_too() -> None:
    text = shown(160)
    assert "(6, 6) (-6, 6) (-6, -6) (6, -6)" in text
    assert [part for part in NUMBERS if part not in text] == []


def test_the_narrowest_keep_the_rate() -> None:
    text = shown(30)
    assert "100/100" in text
    assert "100.0%" in text
    assert "96.3" not in text


LEFT_OUT = ("waypoints [m]", "95 % CI [%]", "paper", "falls", "time-outs", "time [s]", "SPL")


@pytest.mark.parametrize(
    ("width", "left_out"),
    [
        (30, LEFT_OUT),
        (60, ("waypoints [m]", "time [s]", "SPL")),
        (80, ("waypoints [m]",)),
        (160, ()),
    ],
)
def test_what_is_left_out_is_said(width: int, left_out: tuple[str, ...]) -> None:
    table, _, told = " ".join(shown(width).split()).partition(" left out: ")
    heads, _, how = told.partition("; ")
    assert heads == ", ".join(left_out)
    assert how.startswith("a wider terminal or runs/walker/evaluation.json shows ") == bool(left_out)
    assert all(heading not in table.partition("─")[0] for heading in left_out if heading != "paper")


def test_whose_figures_the_papers_are_is_said_below() -> None:
    assert "\npaper: the published rate that the suite gives for a case\n" in shown(160)
