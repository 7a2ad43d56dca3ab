from __future__ import annotations

from pathlib import Path

from tests.evaluation.found import paper_evaluation
from waypointctl.evaluation.result import names_of, notes_on_names

ONE, TWO = paper_evaluation("walker", None, "state", 1), paper_evaluation("walker", None, "state", 2)
OTHER = paper_evaluation("other", None, "state", 3)
FOLDERS = [Path("a/walker"), Path("b/walker"), Path("other")]


def test_a_name_of_its_own_is_what_a_policy_is_called() -> None:
    assert names_of([ONE, OTHER], FOLDERS[:2]) == ["walker", "other"]
    assert notes_on_names([ONE, OTHER], ["walker", "other"]) == ()


def test_two_of_one_name_are_called_by_their_folders_as_they_were_given() -> None:
    names = names_of([ONE, TWO, OTHER], FOLDERS)
    assert names == ["a/walker", "b/walker", "other"]
    assert notes_on_names([ONE, TWO, OTHER], names) == ("2 different policies are called 'walker'",)


def test_without_folders_their_hashes_tell_them_apart() -> None:
    assert names_of([ONE, TWO]) == ["walker 1111111", "walker 2222222"]


def test_one_and_the_same_policy_is_said_to_be() -> None:
    names = names_of([ONE, ONE, OTHER], FOLDERS)
    assert names == ["a/walker", "b/walker", "other"]
    note = "a/walker and b/walker are one and the same policy: SHA-256 1111111..."
    assert notes_on_names([ONE, ONE, OTHER], names) == (note,)


def test_a_folder_given_twice_is_numbered() -> None:
    assert names_of([ONE, ONE], FOLDERS[:1] * 2) == ["a/walker (1)", "a/walker (2)"]
    assert names_of([ONE, TWO, ONE]) == ["walker 1111111 (1)", "walker 2222222", "walker 1111111 (2)"]


def test_both_are_said_where_both_are_so() -> None:
    names = names_of([ONE, ONE, TWO], [*FOLDERS[:2], Path("c")])
    assert [note.split(" are ")[0] for note in notes_on_names([ONE, ONE, TWO], names)] == [
        "a/walker and b/walker",
        "2 different policies",
    ]
