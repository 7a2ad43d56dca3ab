from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NoReturn

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.budget import examples
from tests.flight.operator.channel import AIRTIME_NS, DELAY_NS, HOLD, ROUND_TRIP_NS, Channel, ack, frame, ground, stages
from waypointctl.flight.link.direction import NEVER, NOISE, QUEUE_FULL, Delivery
from waypointctl.flight.operator.dispatcher import UNANSWERED, Dispatcher
from waypointctl.flight.operator.requests import CommandRequest
from waypointctl.flight.operator.timing import RetryPolicy
from waypointctl.log.messages import (
    FINAL_STAGES,
    Ack,
    Clock,
    Command,
    CommandKind,
    CommandStage,
    Event,
    Mode,
    Stage,
)


def test_a_command_that_is_acknowledged_is_sent_once() -> None:
    channel = Channel()
    dispatcher, told = ground(channel)
    assert dispatcher.issue(5, HOLD) == 1
    dispatcher.wake(5)
    assert stages(told) == [(5, Stage.QUEUED, 1), (5, Stage.SENT, 1)]
    assert dispatcher.wake_ns == 5 + AIRTIME_NS + ROUND_TRIP_NS
    dispatcher.on_message(1000, ack(Stage.RECEIVED))
    assert dispatcher.wake_ns is None
    assert [(one.id, one.attempt, one.issued_ns) for one in channel.arrived] == [(1, 1, 5)]


def test_a_lost_command_is_sent_again_under_its_id_and_the_loss_is_on_the_links_clock() -> None:
    channel = Channel(lose=[True, False])
    dispatcher, told = ground(channel)
    dispatcher.issue(0, HOLD)
    late_ns = AIRTIME_NS + ROUND_TRIP_NS
    for now in (0, AIRTIME_NS, late_ns - 1, late_ns):
        assert dispatcher.wake(now) == []
    dispatcher.wake(late_ns)
    assert stages(told) == [
        (0, Stage.QUEUED, 1),
        (0, Stage.SENT, 1),
        (AIRTIME_NS, Stage.LOST, 1),
        (late_ns, Stage.UNKNOWN, 1),
        (late_ns, Stage.QUEUED, 2),
        (late_ns, Stage.SENT, 2),
    ]
    lost = next(one for one in told if isinstance(one, CommandStage) and one.stage is Stage.LOST)
    assert (lost.clock, lost.reason) == (Clock.LINK, NOISE)
    assert [(one.id, one.attempt) for one in channel.arrived] == [(1, 2)]
    texts = [one.text for one in told if isinstance(one, Event)]
    assert texts == [
        "command 1 sent: hold",
        "command 1 sent again (transmission 2): transmission 1 was not acknowledged",
    ]


def test_a_command_is_given_up_after_its_retries() -> None:
    dispatcher, told = ground(Channel(lose=[True] * 9), retries=2)
    dispatcher.issue(0, HOLD)
    while dispatcher.wake_ns is not None:
        dispatcher.wake(dispatcher.wake_ns)
    assert dispatcher.unanswered == (1,)
    assert [attempt for _, stage, attempt in stages(told) if stage is Stage.QUEUED] == [1, 2, 3]
    unknown = [one.reason for one in told if isinstance(one, CommandStage) and one.stage is Stage.UNKNOWN]
    assert unknown == [UNANSWERED] * 3


def test_an_expired_command_is_not_sent_again() -> None:
    dispatcher, told = ground(Channel(lose=[True] * 9))
    dispatcher.issue(0, CommandRequest(CommandKind.HOLD, expires_ns=ROUND_TRIP_NS))
    while dispatcher.wake_ns is not None:
        dispatcher.wake(dispatcher.wake_ns)
    assert dispatcher.unanswered == (1,)
    assert max(attempt for _, _, attempt in stages(told)) == 1


def test_a_command_that_expires_at_mission_start_is_not_sent_again() -> None:
    channel = Channel()
    dispatcher, _ = ground(channel)
    dispatcher.issue(0, CommandRequest(CommandKind.HOLD, expires_ns=0))
    dispatcher.wake(AIRTIME_NS + ROUND_TRIP_NS)
    assert (dispatcher.unanswered, len(channel.arrived)) == ((1,), 1)


def test_what_the_own_sender_refuses_is_lost_at_once_and_tried_again() -> None:
    deliveries = [Delivery(NEVER, NEVER, (), QUEUE_FULL)]
    channel = Channel()

    def uplink(now_ns: int, make: Callable[[int], Command]) -> Delivery:
        return deliveries.pop() if deliveries else channel(now_ns, make)

    dispatcher, told = ground(uplink)
    dispatcher.issue(0, HOLD)
    assert stages(told) == [(0, Stage.QUEUED, 1), (0, Stage.LOST, 1)]
    dispatcher.wake(ROUND_TRIP_NS)
    assert [one.attempt for one in channel.arrived] == [2]


def test_without_acknowledgements_nothing_is_sent_again() -> None:
    dispatcher, told = ground(Channel(lose=[True]), acknowledged=False)
    dispatcher.issue(0, HOLD)
    dispatcher.wake(AIRTIME_NS)
    assert dispatcher.wake_ns is None
    assert [stage for _, stage, _ in stages(told)] == [Stage.QUEUED, Stage.SENT, Stage.LOST]


def test_a_robot_at_rest_whose_verdict_was_lost_is_asked_again() -> None:
    channel = Channel()
    dispatcher, _ = ground(channel)
    dispatcher.issue(0, HOLD)
    dispatcher.on_message(1000, ack(Stage.STARTED))
    dispatcher.on_message(2000, frame(Mode.NAVIGATING))
    assert dispatcher.wake_ns in (0, None)
    dispatcher.wake(2000)
    dispatcher.on_message(3000, frame(Mode.DONE))
    assert dispatcher.wake_ns == 3100, "the verdict may still be on its way"
    dispatcher.on_message(3050, frame(Mode.DONE))
    assert dispatcher.wake_ns == 3100, "a second frame does not put it off"
    dispatcher.wake(3100)
    assert [(one.id, one.attempt) for one in channel.arrived] == [(1, 1), (1, 2)]
    dispatcher.on_message(5200, ack(Stage.COMPLETED))
    assert dispatcher.wake(10_000) == []
    assert dispatcher.wake_ns is None


@pytest.mark.parametrize(
    ("not_before_ns", "frame_ns", "mode", "target", "queries"),
    [
        (-1, 901, Mode.DONE, -1, True),
        (-1, 900, Mode.DONE, -1, False),  # no newer than the last report
        (901, 901, Mode.DONE, -1, True),
        (902, 901, Mode.DONE, -1, False),  # kept for its time
        (-1, 901, Mode.SAFE, -1, True),
        (-1, 901, Mode.SAFE, 0, False),  # it has something to go on with
        (-1, 901, Mode.NAVIGATING, -1, False),
    ],
)
def test_a_robot_at_rest_is_asked_only_after_what_it_should_have_ended(
    not_before_ns: int, frame_ns: int, mode: Mode, target: int, queries: bool
) -> None:
    dispatcher, _ = ground(Channel())
    dispatcher.issue(0, CommandRequest(CommandKind.HOLD, not_before_ns=not_before_ns))
    dispatcher.wake(AIRTIME_NS)
    dispatcher.on_message(1000, replace(ack(Stage.STARTED), issued_ns=900))
    dispatcher.on_message(2000, replace(frame(mode), issued_ns=frame_ns, target=target))
    assert (dispatcher.wake_ns is not None) is queries


def test_an_acknowledgement_that_arrives_out_of_order_does_not_set_a_command_back() -> None:
    dispatcher, _ = ground(Channel())
    dispatcher.issue(0, HOLD)
    dispatcher.on_message(1000, replace(ack(Stage.STARTED), issued_ns=900))
    dispatcher.on_message(1010, replace(ack(Stage.ACCEPTED), issued_ns=899))
    assert dispatcher.state()["open"] == [[1, 1, "started", None]]
    dispatcher.on_message(1020, replace(ack(Stage.ACCEPTED, 1), issued_ns=900))
    assert dispatcher.state()["open"] == [[1, 1, "accepted", None]], "of two of one moment the later to arrive"


def test_of_several_that_are_late_the_oldest_is_sent_first_and_each_once() -> None:
    answers = iter([300, 200, 100, 900, 900, 900])
    channel = Channel()
    dispatcher = Dispatcher(channel, RetryPolicy(True, 3, lambda _: next(answers), patience_ns=100), lambda _: None)
    for _ in range(3):
        dispatcher.issue(0, HOLD)
    assert dispatcher.wake(0) == []
    dispatcher.wake(400)
    assert [(one.id, one.attempt) for one in channel.arrived] == [(1, 1), (2, 1), (3, 1), (1, 2), (2, 2), (3, 2)]
    assert dispatcher.wake_ns in (0, 10, 400, 410)
    dispatcher.wake(500)
    assert dispatcher.wake_ns == 900


def test_when_to_wake_costs_no_more_with_thousands_of_open_commands() -> None:
    dispatcher, _ = ground(Channel())
    looked_up = 0

    class Counting(dict[int, object]):
        def __getitem__(self, command_id: int) -> object:
            nonlocal looked_up
            looked_up += 1
            return super().__getitem__(command_id)

        def values(self) -> NoReturn:
            raise AssertionError("all of them are looked at")

    for _ in range(2000):
        dispatcher.issue(0, HOLD)
    dispatcher._open = Counting(dispatcher._open)  # type: ignore[assignment]
    dispatcher.wake(AIRTIME_NS)
    for _ in range(100):
        assert dispatcher.wake_ns == AIRTIME_NS + ROUND_TRIP_NS
    assert looked_up <= 200


@given(
    st.lists(st.integers(0, 3000), min_size=1, max_size=8),
    st.lists(st.booleans(), max_size=30),
    st.lists(st.booleans(), max_size=60),
    st.integers(0, 3),
)
@settings(max_examples=examples(200), deadline=None)
def test_each_command_ends_acknowledged_or_given_up(
    gaps: list[int], lost_up: list[bool], lost_down: list[bool], retries: int
) -> None:
    channel = Channel(lose=list(lost_up))
    dispatcher, told = ground(channel, retries)
    due = [sum(gaps[: i + 1]) for i in range(len(gaps))]
    answers: list[tuple[int, Ack]] = []
    heard: set[int] = set()
    read = 0
    while due or answers or dispatcher.wake_ns is not None:
        times = [
            *due[:1],
            *(at for at, _ in answers),
            *([dispatcher.wake_ns] if dispatcher.wake_ns is not None else []),
        ]
        now = min(times)
        for _, answer in [pair for pair in answers if pair[0] == now]:
            dispatcher.on_message(now, answer)
            heard.add(answer.command_id)
        answers = [pair for pair in answers if pair[0] > now]
        while due and due[0] == now:
            due.pop(0)
            dispatcher.issue(now, HOLD)
        dispatcher.wake(now)
        for command in channel.arrived[read:]:
            if not (lost_down and lost_down.pop(0)):
                answers.append((command.received_ns + DELAY_NS, ack(Stage.COMPLETED, command.id)))
        read = len(channel.arrived)
    times = [one.time_ns for one in told]
    assert times == sorted(times), "told in the order of time"
    assert heard | set(dispatcher.unanswered) == set(range(1, len(gaps) + 1))
    for command_id in dispatcher.unanswered:
        assert (
            sum(
                one.command_id == command_id and one.stage is Stage.QUEUED
                for one in told
                if isinstance(one, CommandStage)
            )
            == retries + 1
        )
    sent = [one for one in told if isinstance(one, CommandStage) and one.stage is Stage.SENT]
    assert len(sent) == len(channel.arrived) + sum(
        isinstance(one, CommandStage) and one.stage is Stage.LOST for one in told
    )
    assert not any(one.stage in FINAL_STAGES for one in told if isinstance(one, CommandStage)), "the robot's to say"
