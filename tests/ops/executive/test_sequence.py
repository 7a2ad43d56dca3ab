"""Commands that come in another order than they were issued in: the robot ends up where the order of issue puts it."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from itertools import permutations
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.ops.executive.rig import SECOND, A, B, C, Rig
from waypointctl.log.messages import CommandKind, Mode, PlannedWaypoint, Stage

UPLOAD, APPEND, RELEASE, GO_TO = (
    CommandKind.UPLOAD_PLAN,
    CommandKind.APPEND_PLAN,
    CommandKind.RELEASE,
    CommandKind.GO_TO,
)
HOLD, RESUME, ABORT, CANCEL, HOME = (
    CommandKind.HOLD,
    CommandKind.RESUME,
    CommandKind.ABORT,
    CommandKind.CANCEL,
    CommandKind.RETURN_HOME,
)


@dataclass(frozen=True)
class Sent:
    """A command before it has an id."""

    kind: CommandKind
    waypoints: tuple[PlannedWaypoint, ...] = ()
    released: int = -1
    target_id: int = -1
    value: float = 1.0
    not_before: float | None = None

    @property
    def start(self) -> float:
        """When it is to start, if it arrives at 1 s."""
        return 1.0 if self.not_before is None else self.not_before


TIMES = (1.0, 1.02, 9.98, 10.0, 10.02, 19.98, 20.0, 20.02)  # of looking at the world [s]


def send(rig: Rig, now: float, one: Sent, number: int, **arguments: Any) -> None:
    """Hand over a command."""
    arguments = {"released": one.released, "target_id": one.target_id, "value": one.value, **arguments}
    rig.send(now, one.kind, *one.waypoints, id=number, on_failure="abort", **arguments)


def arrived(stream: list[Sent], order: tuple[int, ...]) -> Rig:
    """Return a robot that got a stream at 1 s, in an order; ids are places in the stream, from 1."""
    rig = Rig()
    for number in order:
        send(rig, 1.0, stream[number - 1], number, not_before=stream[number - 1].not_before)
    rig.sense(1.02, "start")
    return rig


def done(stream: list[Sent], order: tuple[int, ...]) -> list[tuple[object, ...]]:
    """Return what a robot does that gets a stream at 1 s, in an order."""
    rig, seen = Rig(), []
    for number in order:
        send(rig, 1.0, stream[number - 1], number, not_before=stream[number - 1].not_before)
    for time in TIMES:
        rig.sense(time, "start")
        seen.append(busy(rig))
    return [*seen, doing(rig)]


def wanted(stream: list[Sent]) -> list[tuple[object, ...]]:
    """Return what a robot does that gets every command at its start, those that start together by their ids.

    It never hears of what an abort or a cancel had ended by then, nor of any `not_before`.
    """
    rig, seen, ids, ended = Rig(), [], dict[int, int](), set[int]()
    for time in TIMES:
        for number, one in enumerate(stream, 1):
            if number in ended or one.start != time:
                continue
            to_come = {other for other, older in enumerate(stream[: number - 1], 1) if older.start > time}
            ended |= to_come if one.kind is ABORT else to_come & {one.target_id}
            ids[number] = len(ids) + 1
            send(rig, time, one, ids[number], target_id=ids.get(one.target_id, -1))
        rig.sense(time, "start")
        seen.append(busy(rig))
    return [*seen, doing(rig)]


def busy(rig: Rig) -> tuple[object, ...]:
    """Return what a robot is doing, and is still to do."""
    executive = rig.executive
    plan: Any = executive.state()["plan"]
    open_items = [(item["waypoint"], item["released"]) for item in plan["items"] if not item["over"]]
    return executive.mode, executive.goals.tolist() if executive.on_foot else None, open_items


def doing(rig: Rig) -> tuple[object, ...]:
    """Return what a robot is doing and is still to do, and, if it pauses, what it does when it is resumed."""
    mode = rig.executive.mode
    if mode is Mode.PAUSED:
        rig.send(30.0, RESUME, id=100)
    return mode, rig.executive.target, *busy(rig)


TIMELESS = [replace(waypoint, timeout_ns=1000 * SECOND) for waypoint in (A, B, C)]
setting = st.builds(lambda value: Sent(CommandKind.SET_TOLERANCE, value=value), st.sampled_from([0.2, 2.0]))
going = st.builds(lambda to: Sent(GO_TO, (to,)), st.sampled_from(TIMELESS))
uploading = st.builds(lambda released: Sent(UPLOAD, tuple(TIMELESS), released=released), st.sampled_from([-1, 0, 1, 2]))
releasing = st.builds(lambda released: Sent(RELEASE, released=released), st.sampled_from([-1, 1, 2, 3]))
halting = st.sampled_from([Sent(HOLD), Sent(RESUME), Sent(ABORT), Sent(HOME)])


@st.composite
def streams(draw: st.DrawFn) -> tuple[list[Sent], tuple[int, ...]]:
    """Draw up to six commands, some of which cancel an earlier one that lasts, and an order of arrival."""
    start = st.sampled_from([None, None, 10.0, 20.0])
    command: st.SearchStrategy[Sent] = st.builds(
        lambda one, not_before: replace(one, not_before=not_before),
        st.one_of(going, uploading, releasing, halting, setting),
        start,
    )
    stream = draw(st.lists(command, min_size=2, max_size=5))
    lasting = [number for number, one in enumerate(stream, 1) if one.kind in (GO_TO, UPLOAD, HOME)]
    takes_back = draw(st.booleans())
    if lasting and takes_back:
        target = draw(st.sampled_from(lasting))
        stream.insert(draw(st.integers(target, len(stream))), Sent(CANCEL, target_id=target, not_before=draw(start)))
    return stream, tuple(draw(st.permutations(range(1, len(stream) + 1))))


@given(streams())
@settings(max_examples=600, deadline=None)
def test_whatever_order_commands_come_in_the_robot_does_what_the_order_of_issue_says(
    case: tuple[list[Sent], tuple[int, ...]],
) -> None:
    stream, order = case
    assert done(stream, order) == wanted(stream)


@given(st.permutations(range(1, 30)), st.lists(st.integers(1, 29), max_size=20))
@settings(max_examples=100, deadline=None)
def test_the_carrot_that_is_followed_never_goes_back(order: list[int], doubled: list[int]) -> None:
    rig = Rig()
    followed = []
    for number in order + doubled:  # those that come again are answered, and no more
        rig.send(1.0, GO_TO, replace(A, index=-1, x_m=float(number)), id=number)
        assert rig.executive.target is not None
        followed.append((rig.executive.command_id, rig.executive.target.x_m))
    assert followed == sorted(followed)
    assert followed[-1] == (29, 29.0)
    late = [number for place, number in enumerate(order) if number < max(order[: place + 1])]
    assert [rig.life(number) for number in late] == [[Stage.RECEIVED, Stage.SKIPPED]] * len(late)
    assert all(rig.ended(number)[1].startswith("overtaken by command ") for number in late)


@pytest.mark.parametrize("order", list(permutations((1, 2, 3))))
def test_an_abort_is_not_undone_by_what_was_issued_before_it(order: tuple[int, ...]) -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(UPLOAD, (B, C)), Sent(ABORT)], order)
    assert (rig.executive.mode, rig.executive.target) == (Mode.IDLE, None)
    assert all(rig.stage(number) in {Stage.CANCELLED, Stage.SUPERSEDED, Stage.SKIPPED} for number in (1, 2))


def test_a_plan_that_comes_after_its_hold_stands_until_it_is_resumed() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(HOLD)], (2, 1))
    assert (rig.executive.mode, rig.executive.target, rig.stage(1)) == (Mode.PAUSED, A, Stage.STARTED)
    assert rig.events[-1].text == "standing: by command 2"
    rig.send(50.0, RESUME, id=3)
    assert rig.sense(51.0, "start") is Mode.WALKING
    assert rig.sense(52.0, "a") is Mode.DONE


def test_a_hold_that_comes_after_its_resume_is_dropped() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(HOLD), Sent(RESUME)], (1, 3, 2))
    assert rig.stage(3) is Stage.COMPLETED
    assert rig.ended(2) == (Stage.SKIPPED, "overtaken by command 3")
    assert rig.executive.mode is Mode.WALKING


def test_what_is_cancelled_before_it_comes_is_not_done() -> None:
    rig = arrived([Sent(GO_TO, (A,)), Sent(GO_TO, (B,)), Sent(CANCEL, target_id=2), Sent(HOLD)], (1, 3, 2))
    assert rig.ended(2) == (Stage.CANCELLED, "by command 3")
    assert rig.executive.mode is Mode.IDLE
    rig = arrived([Sent(GO_TO, (A,)), Sent(HOLD), Sent(CANCEL, target_id=2)], (1, 3, 2))
    assert rig.life(2) == [Stage.RECEIVED, Stage.CANCELLED]
    assert rig.executive.mode is Mode.WALKING


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


def test_what_came_out_of_turn_is_in_the_state_and_what_did_not_is_not() -> None:
    rig = arrived([Sent(UPLOAD, (A, B), released=0), Sent(RELEASE, released=1)], (1, 2))
    assert "sequence" not in rig.executive.state()
    rig.send(2.0, CANCEL, id=5, target_id=3)
    state = rig.executive.state()
    assert state["sequence"] == {
        "obeyed": {"upload_plan": [[1, SECOND]], "release": [[2, SECOND]], "cancel": [[5, 2 * SECOND]]},
        "released": [[2, 1]],
        "values": {},
        "cancelled": [[3, 5, 2 * SECOND]],
    }
    assert json.loads(json.dumps(state)) == state
