"""Any commands, for any time, in any order: the robot does what the order of issue says."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.budget import examples
from tests.flight.executive.rig import SECOND, A, B, C, Rig
from tests.flight.executive.sent import Sent, busy, doing, send
from waypointctl.log.messages import CommandKind

UPLOAD, GO_TO, HOME = CommandKind.UPLOAD_PLAN, CommandKind.GO_TO, CommandKind.RETURN_HOME
ABORT, CANCEL = CommandKind.ABORT, CommandKind.CANCEL
TIMES = (1.0, 1.02, 9.98, 10.0, 10.02, 19.98, 20.0, 20.02)  # of looking at the world [s]
TIMELESS = [replace(waypoint, timeout_ns=1000 * SECOND) for waypoint in (A, B, C)]


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


setting = st.builds(lambda value: Sent(CommandKind.SET_TOLERANCE, value=value), st.sampled_from([0.2, 2.0]))
going = st.builds(lambda to: Sent(GO_TO, (to,)), st.sampled_from(TIMELESS))
uploading = st.builds(lambda released: Sent(UPLOAD, tuple(TIMELESS), released=released), st.sampled_from([-1, 0, 1, 2]))
releasing = st.builds(lambda released: Sent(CommandKind.RELEASE, released=released), st.sampled_from([-1, 1, 2, 3]))
halting = st.sampled_from([Sent(CommandKind.HOLD), Sent(CommandKind.RESUME), Sent(ABORT), Sent(HOME)])


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
@settings(max_examples=examples(400), deadline=None)
def test_whatever_order_commands_come_in_the_robot_does_what_the_order_of_issue_says(
    case: tuple[list[Sent], tuple[int, ...]],
) -> None:
    stream, order = case
    assert done(stream, order) == wanted(stream)
