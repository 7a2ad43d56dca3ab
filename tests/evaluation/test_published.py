"""Whose figures stand under 'paper'."""

from __future__ import annotations

from tests.evaluation.found import case_result, paper_evaluation
from waypointctl.evaluation.published import PAPER_TABLES_NOTE, published_note
from waypointctl.evaluation.results_grid import results_grid
from waypointctl.evaluation.suite import load_suite
from waypointctl.evaluation.tables import tables

WALKER = paper_evaluation("walker", "waypoints", "egocentric", 9)
FIVE = paper_evaluation("five", "waypoints", "state_goal", 8)
THEIRS = "paper: the rate that Blum, Jones and Yoshida report for their policy 5, of 10 trials"
OWN = "paper: the published rate that the suite gives for a case"


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
