from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from waypointctl.log.messages import Checkpoint, Command, CommandKind, PlannedWaypoint, Reward, State
from waypointctl.replay.comparator import Difference, bits_of, difference, different_bits

STATE = State(20, 1, np.arange(3.0), np.array([0.0, np.nan]), np.zeros(2))
WAYPOINT = PlannedWaypoint(0, "a", 0.0, 1.0, "box", 0.5, 10, 0)
COMMAND = Command(1, CommandKind.GO_TO, (WAYPOINT,), "abort", 0, 5)


def test_a_record_is_the_same_as_its_equal_even_where_it_is_no_number() -> None:
    other = State(20, 1, np.arange(3.0), np.array([0.0, np.nan]), np.zeros(2))
    assert difference(STATE, other) is None


def test_the_first_component_that_differs_is_named_with_both_values_and_their_bits() -> None:
    other = replace(STATE, qpos=np.array([0.0, np.nextafter(1.0, 2.0), 9.0]))
    assert difference(STATE, other) == Difference(
        "qpos[1]", "1.0 (0x3ff0000000000000)", "1.0000000000000002 (0x3ff0000000000001)", rounding=True
    )


def test_what_rounding_may_leave_can_be_let_pass_and_no_more() -> None:
    near = replace(STATE, qpos=np.array([0.0, np.nextafter(1.0, 2.0), 2.0]))
    assert difference(STATE, near, rounded=True) is None
    for value in (1.00001, np.nan, np.inf):
        found = difference(STATE, replace(STATE, qpos=np.array([0.0, value, 2.0])), rounded=True)
        assert found is not None
        assert (found.component, found.rounding) == ("qpos[1]", False)


def test_of_long_texts_what_is_around_the_difference_is_shown() -> None:
    logged = Checkpoint(0, 0, np.zeros(2), "a" * 5000 + "x" + "b" * 5000, "")
    found = difference(logged, replace(logged, executive="a" * 5000 + "y" + "b" * 5000))
    assert found is not None
    assert found.logged == f"...{'a' * 60}x{'b' * 59}..."
    assert found.replayed == f"...{'a' * 60}y{'b' * 59}..."


def test_the_sign_of_zero_is_a_difference() -> None:
    found = difference(STATE, replace(STATE, qacc_warmstart=np.array([0.0, -0.0])))
    assert found is not None
    assert (found.component, found.logged) == ("qacc_warmstart[1]", "0.0 (0x0000000000000000)")
    assert found.replayed == "-0.0 (0x8000000000000000)"
    minus = replace(COMMAND, waypoints=(replace(WAYPOINT, x_m=-0.0),))
    assert difference(COMMAND, minus) is not None


def test_what_lies_deeper_is_named_by_its_path() -> None:
    moved = replace(COMMAND, waypoints=(replace(WAYPOINT, y_m=2.0),))
    found = difference(COMMAND, moved)
    assert found is not None
    assert found.component == "waypoints[0].y_m"
    paid, other = (
        Reward(20, 0, (("progress", 1.0), ("fall", 0.0)), 1.0),
        Reward(20, 0, (("progress", 1.0), ("fall", 2.0)), 1.0),
    )
    found = difference(paid, other)
    assert found is not None
    assert found.component == "terms[1][1]"


def test_another_kind_of_record_another_size_and_another_name_are_differences() -> None:
    assert difference(STATE, COMMAND) == Difference("type", "State", "Command", rounding=False)
    other_size = difference(STATE, replace(STATE, qpos=np.zeros(4)))
    assert other_size == Difference("qpos.shape", "(3,)", "(4,)", rounding=False)
    assert difference(STATE, replace(STATE, step=2)) == Difference("step", "1", "2", rounding=False)
    two = replace(COMMAND, waypoints=(WAYPOINT, WAYPOINT))
    found = difference(COMMAND, two)
    assert found is not None
    assert found.component == "waypoints"


def test_bits_are_those_of_ieee_754() -> None:
    assert (bits_of(0.0), bits_of(-0.0), bits_of(1.0)) == (0, 1 << 63, 0x3FF << 52)


@pytest.mark.parametrize(
    ("logged", "replayed", "near"),
    [
        (0.0, 1e-12, True),
        (0.0, 1.5e-12, False),
        (1.5, 1.5 + 1.4e-12, True),
        (1000.0, 1000.0 + 5e-10, True),
        (-1000.0, -1000.0 + 5e-10, True),
        (1000.0, 1000.0 + 2e-9, False),
    ],
)
def test_rounding_is_absolute_and_above_one_relative(logged: float, replayed: float, near: bool) -> None:
    found = difference(Reward(20, 0, (), logged), Reward(20, 0, (), replayed))
    assert found is not None
    assert found.rounding is near


@pytest.mark.parametrize(
    ("logged", "replayed", "shown"),
    [
        ("a" * 120, "b" * 120, ("a" * 120, "b" * 120)),
        ("a" * 121, "a" * 10 + "b", (f"...{'a' * 70}...", f"...{'a' * 10}b...")),
        ("a" * 100, "a" * 200, (f"...{'a' * 60}...", f"...{'a' * 120}...")),
    ],
)
def test_short_texts_are_shown_whole_and_long_ones_from_where_they_part(
    logged: str, replayed: str, shown: tuple[str, str]
) -> None:
    one = Checkpoint(0, 0, np.zeros(2), logged, "")
    found = difference(one, replace(one, executive=replayed))
    assert found is not None
    assert (found.logged, found.replayed) == shown


def test_arrays_are_compared_by_their_bits() -> None:
    assert different_bits(np.array([0.0, 1.0, -0.0]), np.array([0.0, 2.0, 0.0])) == [1, 2]
