from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.flight.executive.rig import A, Rig
from waypointctl.flight.command_life import names
from waypointctl.flight.executive.command_tracker import CommandTracker
from waypointctl.log.messages import Command, CommandKind, Stage


def test_a_checkpoint_does_not_grow_with_the_commands_that_have_ended() -> None:
    rig = Rig()
    sizes = {}
    rig.send(0.0, CommandKind.RESUME, id=1, not_before=1e6)
    for number in range(2, 3001):
        rig.send(1.0, CommandKind.GO_TO, A, id=number)
        if number in (2, 200, 300, 3000):
            sizes[number] = len(json.dumps(rig.executive.state()))
    assert sizes[200] > 10 * sizes[2], "while they are few, each is told"
    assert sizes[3000] < 1.05 * sizes[300]
    commands = rig.executive.state()["commands"]
    assert isinstance(commands, dict)
    assert list(commands["records"]) == ["1", *map(str, range(2745, 3001))], "those that are open, and the newest"
    assert commands["older"] == 3000 - 257


def test_what_is_not_in_a_checkpoint_any_more_is_still_obeyed_once() -> None:
    rig = Rig()
    for number in range(1, 400):
        rig.send(1.0, CommandKind.GO_TO, A, id=number)
    rig.send(2.0, CommandKind.GO_TO, A, id=1)
    assert rig.stages_of(1) == [Stage.RECEIVED, Stage.ACCEPTED, Stage.STARTED, Stage.SUPERSEDED]
    assert rig.reminders[-1].stage is Stage.SUPERSEDED


def test_a_checkpoint_does_not_grow_with_the_waypoints_that_are_over() -> None:
    rig, count = Rig(), 1000
    rig.command(0.0, *(replace(A, index=index, name=f"{index:04}") for index in range(count)))
    rig.send(0.0, CommandKind.RELEASE, id=2, released=1)
    sizes = {}
    for index in range(count - 1):
        rig.sense(2.0 + 2 * index, "start")
        rig.sense(3.0 + 2 * index, "a")
        if index in (2, 300, 500):
            sizes[index] = len(json.dumps(rig.executive.state()))
    assert sizes[500] < 1.05 * sizes[300]
    state: Any = rig.executive.state()
    plan = state["plan"]
    assert (plan["at"], plan["begin"], plan["of"], len(plan["items"])) == (999, 744, 1000, 256)
    assert plan["items"][-1]["waypoint"]["index"] == 999
    assert (state["reached"], state["reached_count"]) == ([*range(743, 999)], 999)


def test_a_frame_has_the_newest_open_commands_and_those_that_ended_last() -> None:
    rig = Rig()

    def reported() -> list[int]:
        return [status.command_id for status in rig.executive.statuses]

    assert reported() == []
    for number in (1, 2, 3, 4):
        rig.send(0.0, CommandKind.HOLD, id=number)
    assert reported() == [2, 3, 4]
    for number in (5, 6, 7):
        rig.send(1.0, CommandKind.GO_TO, A, id=number, not_before=90.0)
        assert len(reported()) == 3
    assert reported() == [4, 6, 7]
    rig.send(2.0, CommandKind.CANCEL, id=8, target_id=6)
    assert reported() == [5, 7, 8]
    assert [status.stage for status in rig.executive.statuses] == [Stage.ACCEPTED, Stage.ACCEPTED, Stage.COMPLETED]


@pytest.mark.parametrize(
    ("count", "named"), [(1, "0"), (12, "0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11"), (13, "0 to 12, 13 waypoints")]
)
def test_many_waypoints_are_named_by_the_first_and_the_last(count: int, named: str) -> None:
    assert names([replace(A, name=str(number)) for number in range(count)]) == named


ids = st.integers(1, 12)
times = st.integers(-1, 20)


@given(st.lists(st.tuples(ids, times, times), max_size=12), st.lists(ids, max_size=6), st.lists(times, max_size=4))
def test_what_has_arrived_waits_and_expires_as_when_each_command_is_looked_at(
    arrivals: list[tuple[int, int, int]], cancelled: list[int], looks: list[int]
) -> None:
    tracker, commands = CommandTracker(lambda _: None, lambda _: None), {}
    for number, not_before, expires in arrivals:
        if number in commands:
            continue
        commands[number] = command = Command(
            number, CommandKind.HOLD, (), "", 0, 0, not_before_ns=not_before, expires_ns=expires
        )
        tracker.receive(0, command)
        tracker.advance(0, number, Stage.ACCEPTED)
        tracker.postpone(command)
    for number in range(1, 14):
        assert tracker.knows_all_before(number) == all(one in commands for one in range(1, number))
    still = dict(commands)
    for number in cancelled:
        if number in still:
            tracker.advance(0, number, Stage.CANCELLED)
            del still[number]
    for now in sorted(looks):
        over = [number for number, command in still.items() if 0 <= command.expires_ns < now]
        expiries = [command.expires_ns for command in still.values() if command.expires_ns >= 0]
        assert tracker.next_expiry_ns == min(expiries, default=None)
        assert tracker.expired(now) == over
        for number in over:
            tracker.advance(now, number, Stage.EXPIRED)
            del still[number]
    due = sorted(still.values(), key=lambda command: (command.not_before_ns, command.id))
    assert tracker.pending == due
    assert [tracker.take_due(20) for _ in due] == due


def test_a_stage_that_cannot_follow_is_a_bug() -> None:
    tracker = CommandTracker(lambda _: None, lambda _: None)
    tracker.receive(0, Command(1, CommandKind.HOLD, (), "", 0, 0))
    with pytest.raises(RuntimeError):
        tracker.advance(0, 1, Stage.COMPLETED)
    tracker.advance(0, 1, Stage.REJECTED)
    with pytest.raises(RuntimeError):
        tracker.advance(0, 1, Stage.ACCEPTED)
