from __future__ import annotations

import pytest

from tests.evaluation.found import paper_evaluation
from waypointctl.evaluation.paper_tables import number_of, paper_tables
from waypointctl.evaluation.result import Evaluation
from waypointctl.evaluation.suite import load_suite
from waypointctl.evaluation.tables import tables

SUITE = load_suite("paper")
ONE = paper_evaluation("one", "single point", "state", 0)
TWO = paper_evaluation("two", "waypoints", "state", 1)
THREE = paper_evaluation("three", "waypoints", "state_noise", 2)
FOUR = paper_evaluation("four", "single point", "state_goal", 3)
FIVE = paper_evaluation("five", "waypoints", "state_goal", 8)
WALKER = paper_evaluation("walker", "waypoints", "egocentric", 10)

# Tables 1 to 3 of Blum, Jones and Yoshida, as percentages.
TABLE_1 = {"1": "0%", "2": "0%", "3": "0%", "4": "0%", "5": "90%"}
TABLE_2 = {
    "(10, 10)": "100%",
    "(14, 14)": "70%",
    "(12, 8)": "70%",
    "(8, 12)": "80%",
    "(13, 7)": "30%",
    "(7, 13)": "50%",
    "(6, 6)": "80%",
}
TABLE_3 = {"(7, 7) → (14, 14)": "80%", "(7, 12) → (14, 14)": "90%", "(12, 7) → (14, 14)": "0%"}


def test_a_policy_is_known_by_what_it_sees_and_was_trained_on() -> None:
    numbers = [number_of(SUITE, evaluation) for evaluation in (ONE, TWO, THREE, FOUR, FIVE, WALKER)]
    assert numbers == [1, 2, 3, 4, 5, None]
    assert number_of(SUITE, FIVE.model_copy(update={"training": None})) is None


def test_the_papers_figures_are_the_papers() -> None:
    first, second, third = paper_tables(SUITE, [FIVE])
    assert {row[0]: row[4] for row in first.rows} == TABLE_1
    assert {row[0]: row[1] for row in second.rows} == TABLE_2
    assert {row[0]: row[1] for row in third.rows} == TABLE_3
    assert list(TABLE_2) == [row[0] for row in second.rows]


def test_table_1_has_a_row_for_each_policy_in_the_papers_order_and_the_others_after_it() -> None:
    first, _, _ = paper_tables(SUITE, [WALKER, FIVE, FOUR, THREE, TWO, ONE])
    assert first.title == "Table 1: (7, 12) → (14, 14)"
    assert [column.heading for column in first.columns] == [
        *("#", "policy", "training", "observation", "paper", "success", "95 % CI [%]", "falls", "time-outs"),
    ]
    assert first.rows[0] == ("1", "one", "single point", "state", "0%", "0/10", "0.0-27.8", "10", "0")
    assert first.rows[2][:4] == ("3", "three", "waypoints", "state + noise")
    assert first.rows[4] == ("5", "five", "waypoints", "state + goal", "90%", "8/10", "49.0-94.3", "2", "0")
    assert first.rows[5] == ("", "walker", "waypoints", "egocentric", "", "10/10", "72.2-100.0", "0", "0")


def test_what_was_not_evaluated_keeps_its_place() -> None:
    first, second, _ = paper_tables(SUITE, [TWO, WALKER])
    assert [row[5] for row in first.rows] == ["not evaluated", "1/10", *["not evaluated"] * 3, "10/10"]
    assert second.rows[0] == ("(10, 10)", "100%", "not evaluated", "", "10/10", "72.2-100.0")


def test_tables_2_and_3_have_policy_5_and_the_others_beside_it() -> None:
    _, second, third = paper_tables(SUITE, [ONE, FIVE, WALKER])
    headings = ["path", "paper", "five", "95 % CI [%]", "walker", "95 % CI [%]"]
    assert [column.heading for column in second.columns] == [column.heading for column in third.columns] == headings
    assert third.rows[2] == ("(12, 7) → (14, 14)", "0%", "8/10", "49.0-94.3", "10/10", "72.2-100.0")


def test_two_policies_of_one_name_are_told_apart() -> None:
    again = paper_evaluation("five", "waypoints", "state_goal", 9)
    first, second, _ = paper_tables(SUITE, [FIVE, again])
    assert [row[1] for row in first.rows if row[0] == "5"] == ["five 8888888", "five 9999999"]
    assert [row[5] for row in first.rows if row[0] == "5"] == ["8/10", "9/10"]
    assert len(second.columns) == 6


@pytest.mark.parametrize(("evaluations", "count"), [([FIVE], 1), ([FIVE, WALKER], 3)])
def test_one_policy_has_its_results_and_several_have_the_papers_tables(
    evaluations: list[Evaluation], count: int
) -> None:
    grids = tables(SUITE, evaluations)
    assert len(grids) == count


def test_other_suites_have_one_table_of_all() -> None:
    (grid,) = tables(load_suite("region"), [FIVE, WALKER])
    assert len(grid.rows) == 20
    assert {row[0] for row in grid.rows} == {"five", "walker"}
