from __future__ import annotations

from tests.evaluation.found import case_result, paper_evaluation
from waypointctl.evaluation.grid import Column, Grid, markdown_file
from waypointctl.evaluation.paper_tables import PAPER_TABLES_NOTE, published_note
from waypointctl.evaluation.result import CaseResult, Evaluation
from waypointctl.evaluation.suite import Hold, RandomPaths, load_suite
from waypointctl.evaluation.tables import MARKDOWN_HEAD, failures, results_grid, tables
from waypointctl.mission.fields import Acceptance

WALKER = paper_evaluation("walker", "waypoints", "egocentric", 9)
FIVE = paper_evaluation("five", "waypoints", "state_goal", 8)
THEIRS = "paper: the rate that Blum, Jones and Yoshida report for their policy 5, of 10 trials"
OWN = "paper: the published rate that the suite gives for a case"


def evaluation(*cases: CaseResult, **changes: object) -> Evaluation:
    return paper_evaluation("walker", "waypoints", "state", 9).model_copy(update={"cases": cases, **changes})


def test_failures_are_told_by_their_kind() -> None:
    late = case_result("b", successes=4, falls=0, timeouts=5, orbiting=3, stuck=1, strayed=1)
    told = failures(evaluation(case_result("a"), late))
    assert told == "7 of 20 trials failed: 1 fall, 5 time-outs (3 orbiting, 1 stuck, 1 late), 1 strayed from the hold"
    assert failures(evaluation(case_result("a", successes=10, falls=0))) == "none of 10 trials failed"


def test_an_evaluation_of_an_earlier_version_says_nothing_it_did_not_measure() -> None:
    unmeasured: dict[str, object] = dict.fromkeys(
        ("orbiting", "stuck", "strayed", "legs", "legs_reached", "mean_speed_mps")
    )
    old = evaluation(case_result("a", successes=8, timeouts=1).model_copy(update=unmeasured))
    assert failures(old) == "2 of 10 trials failed: 1 fall, 1 time-out"
    headings = {column.heading for column in results_grid([old]).columns}
    assert headings.isdisjoint({"strayed", "legs", "m/s", "policy", "paper"})


def test_the_title_says_under_which_conditions() -> None:
    narrow = evaluation(
        case_result("a"),
        suite="station",
        acceptance=Acceptance(shape="radius", size_m=0.2),
        suite_acceptance=Acceptance(shape="radius", size_m=0.3),
        hold=Hold(),
    )
    assert results_grid([narrow]).title == (
        "walker in the suite station, seed 1, radius 0.2 m instead of the suite's radius 0.3 m, "
        "then held for 10 s within 0.5 m"
    )
    assert results_grid([narrow, narrow]).title.startswith("suite station, seed 1")


def test_a_row_of_random_paths() -> None:
    course = RandomPaths(name="a", count=20, perimeter="legs")
    drawn = case_result("a", (), legs=190, legs_reached=189, mean_speed_mps=2.0, course=course)
    assert results_grid([evaluation(drawn)]).rows == (
        ("a", "20 random", "9/10", "90.0%", "59.6-98.2", "1", "0", "189/190", "5.00", "0.800", "2.00"),
    )


def test_markdown_is_a_table_that_names_cannot_break() -> None:
    grid = Grid("a*b", (Column("path", is_text=True), Column("n")), (("x|y", "1"), ("<b>", "2")), ("note",))
    assert markdown_file(MARKDOWN_HEAD, [grid]) == (
        MARKDOWN_HEAD + "\n**a\\*b**\n\n| path | n |\n|---|---:|\n| x\\|y | 1 |\n| \\<b> | 2 |\n\nnote\n"
    )


def test_the_papers_suite_has_the_authors_and_their_policy() -> None:
    assert published_note(WALKER) == THEIRS
    assert results_grid([WALKER]).notes[0] == THEIRS


def test_another_suite_has_none_of_their_figures_whatever_it_is_called() -> None:
    own = (case_result("a", ((1.0, 0.0),), paper=0.4), case_result("b"))
    for name in ("mine", "paper"):
        assert published_note(WALKER.model_copy(update={"suite": name, "cases": own})) == OWN
    altered = (WALKER.cases[0].model_copy(update={"paper": 0.99}), *WALKER.cases[1:])
    assert published_note(WALKER.model_copy(update={"cases": altered})) == OWN


def test_where_no_case_has_a_figure_there_is_neither_column_nor_note() -> None:
    bare = WALKER.model_copy(update={"cases": (case_result("a"),)})
    grid = results_grid([bare])
    assert published_note(bare) is None
    assert "paper" not in [column.heading for column in grid.columns]
    assert not any(note.startswith("paper") for note in grid.notes)


def test_the_papers_tables_have_the_note_below_the_last_one() -> None:
    notes = [grid.notes for grid in tables(load_suite("paper"), [FIVE, WALKER])]
    assert notes == [(), (), (PAPER_TABLES_NOTE,)]


def test_policies_that_could_be_taken_for_one_another_are_said_below_the_last_table() -> None:
    *_, last = tables(load_suite("paper"), [FIVE, FIVE], ["a", "b"])
    assert last.notes == (PAPER_TABLES_NOTE, "a and b are one and the same policy: SHA-256 8888888...")
    assert [column.heading for column in last.columns][2::2] == ["a", "b"]
