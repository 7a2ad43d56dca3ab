"""Commands that come in another order than they were issued in: the robot ends up where the order of issue puts it."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import permutations
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.budget import examples
from tests.flight.executive.rig import SECOND, A, B, C, Rig
from tests.flight.executive.sent import Sent, arrived, busy
from waypointctl.log.messages import CommandKind, Mode, Stage

UPLOAD, RELEASE, GO_TO = CommandKind.UPLOAD_PLAN, CommandKind.RELEASE, CommandKind.GO_TO
HOLD, RESUME, ABORT, CANCEL = CommandKind.HOLD, CommandKind.RESUME, CommandKind.ABORT, CommandKind.CANCEL


@given(st.permutations(range(1, 30)), st.lists(st.integers(1, 29), max_size=20))
@settings(max_examples=examples(100), deadline=None)
def test_the_goal_that_is_followed_never_goes_back(order: list[int], doubled: list[int]) -> None:
    rig = Rig()
    followed = []
    for number in order + doubled:  # those that come again are answered, and no more
        rig.send(1.0, GO_TO, replace(A, index=-1, x_m=float(number)), id=number)
        assert rig.executive.target is not None
        followed.append((rig.executive.state()["command_id"], rig.executive.target.x_m))
    assert followed == sorted(followed)
    assert followed[-1] == (29, 29.0)
    late = [number for place, number in enumerate(order) if number < max(order[: place + 1])]
    assert [rig.stages_of(number) for number in late] == [[Stage.RECEIVED, Stage.SKIPPED]] * len(late)
    assert all(rig.ended(number)[1].startswith("overtaken by command ") for number in late)


@pytest.mark.parametrize("order", list(permutations((1, 2, 3))))
def test_an_abort_is_not_undone_by_what_was_issued_before_it(order: tuple[int, ...]) -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(UPLOAD, (B, C)), Sent(ABORT)], order)
    assert (rig.executive.mode, rig.executive.target) == (Mode.IDLE, None)
    assert all(rig.stage(number) in {Stage.CANCELLED, Stage.SUPERSEDED, Stage.SKIPPED} for number in (1, 2))


def test_a_plan_that_comes_after_its_hold_stands_until_it_is_resumed() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(HOLD)], (2, 1))
    assert (rig.executive.mode, rig.executive.target, rig.stage(1)) == (Mode.PAUSED, A, Stage.STARTED)
    assert rig.events[-1].text == "stopped: by command 2"
    rig.send(50.0, RESUME, id=3)
    assert rig.sense(51.0, "start") is Mode.NAVIGATING
    assert rig.sense(52.0, "a") is Mode.DONE


def test_a_hold_that_comes_after_its_resume_is_dropped() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(HOLD), Sent(RESUME)], (1, 3, 2))
    assert rig.stage(3) is Stage.COMPLETED
    assert rig.ended(2) == (Stage.SKIPPED, "overtaken by command 3")
    assert rig.executive.mode is Mode.NAVIGATING


def test_what_is_cancelled_before_it_comes_is_not_done() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(GO_TO, (B,)), Sent(CANCEL, target_id=2), Sent(HOLD)], (1, 3, 2))
    assert rig.ended(2) == (Stage.CANCELLED, "by command 3")
    assert rig.executive.mode is Mode.IDLE
    rig = arrived([Sent(GO_TO, (A,)), Sent(HOLD), Sent(CANCEL, target_id=2)], (1, 3, 2))
    assert rig.stages_of(2) == [Stage.RECEIVED, Stage.CANCELLED]
    assert rig.executive.mode is Mode.NAVIGATING


def test_what_is_wrong_is_still_refused_where_nothing_is_to_come() -> None:
    alone = [Sent(RELEASE), Sent(RESUME), Sent(CANCEL, target_id=9), Sent(CommandKind.SET_TIMEOUT)]
    rig = arrived(alone, (1, 2, 3, 4))
    assert [rig.stage(number) for number in (1, 2, 3, 4)] == [Stage.REJECTED] * 4


def test_a_late_abort_ends_what_was_issued_before_it_and_leaves_the_rest() -> None:
    rig = Rig()
    rig.send(0.0, GO_TO, A, id=1, not_before=50.0)
    rig.send(1.0, GO_TO, B, id=3)
    assert rig.send(2.0, ABORT, id=2) is Stage.COMPLETED
    assert rig.ended(1) == (Stage.CANCELLED, "by command 2")
    assert rig.executive.target == B
    rig.send(3.0, GO_TO, C, id=5)
    rig.send(4.0, ABORT, id=4)
    assert rig.ended(4) == (Stage.SKIPPED, "overtaken by command 5")
    assert rig.executive.target == C


def test_a_command_counts_from_the_time_that_it_is_for() -> None:
    rig = Rig()
    rig.send(0.0, GO_TO, B, id=2)
    assert rig.send(1.0, GO_TO, A, id=1, not_before=5.0) is Stage.ACCEPTED
    rig.sense(5.0, "start")
    assert rig.executive.target == A, "it was issued earlier, for later"
    rig.send(6.0, ABORT, id=4)
    assert rig.send(7.0, GO_TO, C, id=3, not_before=20.0) is Stage.SKIPPED, "an abort ends what waits too"


def test_a_late_abort_ends_nothing_that_was_issued_after_it_and_waits() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(ABORT), Sent(GO_TO, (B,), not_before=10.0)], (1, 3, 2))
    assert rig.ended(1) == (Stage.CANCELLED, "by command 2")
    assert (rig.executive.mode, rig.stage(3)) == (Mode.IDLE, Stage.ACCEPTED)
    rig.sense(10.0, "start")
    assert rig.executive.target == B


def test_an_abort_for_later_ends_what_was_begun_before_its_time_whenever_it_was_issued() -> None:
    later = Sent(GO_TO, (C,), not_before=20.0)
    rig = arrived([Sent(ABORT, not_before=10.0), Sent(GO_TO, (A,)), later], (1, 2, 3))
    assert rig.sense(9.98, "start") is Mode.NAVIGATING
    assert rig.sense(10.0, "start") is Mode.IDLE
    assert (rig.ended(2), rig.stage(3)) == ((Stage.CANCELLED, "by command 1"), Stage.ACCEPTED)
    rig.sense(20.0, "start")
    assert rig.executive.target == C


def test_an_abort_that_is_overtaken_still_ends_what_was_issued_before_it() -> None:
    rig = arrived([Sent(GO_TO, (A,), not_before=10.0), Sent(ABORT), Sent(GO_TO, (B,))], (3, 2, 1))
    assert rig.ended(2) == (Stage.SKIPPED, "overtaken by command 3")
    assert rig.ended(1) == (Stage.SKIPPED, "overtaken by command 2")
    rig.sense(10.0, "start")
    assert rig.executive.target == B


@pytest.mark.parametrize("order", list(permutations((1, 2, 3))))
def test_of_commands_for_one_time_the_one_issued_first_is_started_first(order: tuple[int, ...]) -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(HOLD, not_before=10.0), Sent(RESUME, not_before=10.0)], order)
    assert rig.sense(10.0, "start") is Mode.NAVIGATING
    assert (rig.stage(2), rig.stage(3)) == (Stage.COMPLETED, Stage.COMPLETED)


def test_what_has_waited_until_now_comes_before_what_arrives_now() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(HOLD, not_before=10.0)], (1, 2))
    rig.sense(9.98, "start")
    assert rig.send(10.0, RESUME, id=3) is Stage.COMPLETED
    assert rig.sense(10.0, "start") is Mode.NAVIGATING
    assert rig.stages_of(2)[-1] is Stage.COMPLETED
    late = arrived([Sent(GO_TO, (A,))], (1,))
    late.send(2.0, HOLD, id=2, not_before=9.985, expires=9.99)
    late.send(10.0, GO_TO, B, id=3)
    assert late.ended(2) == (Stage.EXPIRED, "not started in time"), "between two looks at the clock"


@pytest.mark.parametrize("order", list(permutations((1, 2, 3, 4))))
def test_what_is_kept_is_not_changed_by_what_was_meant_for_what_is_under_way(order: tuple[int, ...]) -> None:
    kept = Sent(UPLOAD, (C, B), released=1, not_before=10.0)
    rig = arrived([Sent(UPLOAD, (A, B), released=1), kept, Sent(RELEASE), Sent(CommandKind.SET_TOLERANCE)], order)
    rig.sense(10.0, "start")
    assert busy(rig)[2] == busy(arrived([replace(kept, not_before=None)], (1,)))[2]


def test_of_two_settings_that_follow_a_command_the_one_that_starts_last_is_taken() -> None:
    changes = [Sent(CommandKind.SET_TOLERANCE, value=0.2, not_before=10.0), Sent(CommandKind.SET_TOLERANCE, value=2.0)]
    rig = arrived([Sent(GO_TO, (A,)), *changes, Sent(HOLD, not_before=10.0), Sent(RESUME)], (2, 3, 4, 5))
    rig.sense(10.0, "start")
    assert rig.send(11.0, GO_TO, A, id=1) is Stage.STARTED
    assert rig.executive.target == replace(A, tolerance_m=0.2)
    assert rig.executive.mode is Mode.PAUSED, "the hold is for later than the resume"


def test_what_is_cancelled_before_its_time_ends_nothing_when_it_comes() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(GO_TO, (B,), not_before=10.0), Sent(CANCEL, target_id=2)], (1, 3))
    rig.send(11.0, GO_TO, B, id=2, not_before=10.0)
    assert rig.stages_of(2) == [Stage.RECEIVED, Stage.CANCELLED]
    assert rig.executive.target == A


def test_what_came_out_of_turn_is_in_the_state_and_what_did_not_is_not() -> None:
    rig = arrived([Sent(UPLOAD, (A, B), released=0), Sent(RELEASE, released=1)], (1, 2))
    assert "sequence" not in rig.executive.state()
    rig.send(2.0, CANCEL, id=5, target_id=3)
    state = rig.executive.state()
    assert state["sequence"] == {
        "executed": {"upload_plan": [[1, SECOND]], "release": [[2, SECOND]], "cancel": [[5, 2 * SECOND]]},
        "released": [[2, 1]],
        "values": {},
        "cancelled": [[3, 5, 2 * SECOND]],
    }
    assert json.loads(json.dumps(state)) == state


def test_a_newer_command_for_the_same_time_comes_after_an_older_one() -> None:
    rig = arrived([Sent(GO_TO, (A,), not_before=10.0), Sent(GO_TO, (B,), not_before=10.0)], (2,))
    rig.sense(10.0, "start")
    rig.send(11.0, GO_TO, A, id=1, not_before=10.0)
    assert rig.ended(1) == (Stage.SKIPPED, "overtaken by command 2")
    assert rig.executive.target == B


def test_of_several_that_overtake_a_command_the_newest_is_named() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(UPLOAD, (B,)), Sent(GO_TO, (C,))], (2, 3, 1))
    assert rig.ended(1) == (Stage.SKIPPED, "overtaken by command 3")


def test_a_hold_that_was_resumed_before_the_plan_came_does_not_stop_it() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(HOLD), Sent(RESUME)], (2, 3, 1))
    assert (rig.executive.mode, rig.stage(1)) == (Mode.NAVIGATING, Stage.STARTED)


@pytest.mark.parametrize(("first", "second", "released"), [(2, 1, 2), (1, 2, 2), (0, 0, 0), (-1, 1, 3)])
def test_of_releases_that_came_before_the_plan_the_one_of_most_waypoints_counts(
    first: int, second: int, released: int
) -> None:
    rig = arrived(
        [Sent(UPLOAD, (A, B, C), released=0), *(Sent(RELEASE, released=it) for it in (first, second))], (2, 3, 1)
    )
    plan: Any = rig.executive.state()["plan"]
    assert [item["released"] for item in plan["items"]] == [place < released for place in range(3)]


def test_what_would_have_begun_before_its_cancel_still_supersedes_the_plan_before_it() -> None:
    cancelled = Sent(GO_TO, (B,), not_before=1.0)
    rig = arrived([Sent(GO_TO, (A,)), cancelled, Sent(CANCEL, target_id=2)], (1, 3, 2))
    assert rig.stage(2) is Stage.CANCELLED
    assert (rig.executive.mode, rig.stage(1)) == (Mode.IDLE, Stage.SUPERSEDED)


def test_only_what_can_still_overtake_a_command_is_kept() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(HOLD), Sent(GO_TO, (B,)), Sent(GO_TO, (C,))], (1, 3, 4))
    state: Any = rig.executive.state()["sequence"]
    assert state["executed"] == {"go_to": [[4, SECOND]]}


def test_what_is_for_all_is_stored_as_the_largest_number() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(RELEASE), Sent(ABORT)], (2, 3))
    state: Any = rig.executive.state()["sequence"]
    assert state["executed"] == {"release": [[2, SECOND]], "abort": [[3, 2**63 - 1]]}
    assert state["released"] == [[2, 2**31]]
