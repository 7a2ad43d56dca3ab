"""Messages of a replay, compared one by one with those of the log, without a flight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from waypointctl.log.comparison import Diverged
from waypointctl.log.messages import Clock, Event, EventKind, Message, Mode, Severity, State, Telemetry
from waypointctl.log.reader import EncodedMessage
from waypointctl.log.records import RawMessage
from waypointctl.log.topics import BY_KIND
from waypointctl.replay.comparator import LogComparator, LogEnded

STATE = State(20, 1, np.arange(3.0), np.zeros(2), np.zeros(2))
FRAME = Telemetry(5, Mode.PAUSED, 1.0, 2.0, 0.5, 0.1, 1.5, 0, (0, 1), 7, 9)
EVENT = Event(30, EventKind.LEG_STARTED, Clock.ROBOT, Severity.INFO, "driving", 0)


def encoded(message: Message) -> EncodedMessage:
    topic = BY_KIND[type(message)]
    return EncodedMessage(topic, RawMessage(0, 0, *topic.times_ns(message), topic.encode(message)), "a.mcap", 0)


def comparator(*logged: Message, bitwise: bool = True) -> LogComparator:
    return LogComparator(iter([encoded(message) for message in logged]), bitwise=bitwise)


def test_equal_messages_are_counted_by_their_topic_until_the_log_ends() -> None:
    compare = comparator(STATE, EVENT, EVENT)
    assert (compare.upcoming_kind, compare.has_ended, compare.step) == (State, False, 0)
    for message in (STATE, EVENT, EVENT):
        assert compare.upcoming is not None
        assert compare.upcoming is compare.upcoming, "it is decoded once"
        assert type(compare.upcoming) is type(message)
        compare(message)
    assert compare.compared == {"/state": 1, "/event": 2}
    assert compare.rounded == {}
    assert (compare.upcoming, compare.upcoming_kind, compare.has_ended, compare.step) == (None, None, True, 1)
    with pytest.raises(LogEnded):
        compare(EVENT)


def test_a_divergence_has_the_step_and_time_of_the_last_state() -> None:
    compare = comparator(STATE, EVENT)
    compare(STATE)
    with pytest.raises(Diverged) as caught:
        compare(replace(EVENT, text="driving on"))
    where = caught.value.where
    assert (where.step, where.time_ns, where.topic, where.component) == (1, 20, "/event", "text")
    assert (where.logged, where.replayed) == ("driving", "driving on")
    assert not caught.value.rounding
    assert compare.compared == {"/state": 1}


@pytest.mark.parametrize("bitwise", [True, False])
def test_what_numpy_computes_may_be_rounded_otherwise_on_another_processor(bitwise: bool) -> None:
    near = replace(FRAME, x_m=np.nextafter(1.0, 2.0).item())
    compare = comparator(FRAME, bitwise=bitwise)
    if bitwise:
        with pytest.raises(Diverged) as caught:
            compare(near)
        assert caught.value.rounding
    else:
        assert compare(near) == FRAME, "the log's own"
        assert (compare.compared, compare.rounded) == ({"/telemetry": 1}, {"/telemetry": 1})


@pytest.mark.parametrize(
    ("logged", "replayed", "rounding"),
    [
        (FRAME, replace(FRAME, x_m=1.1), False),
        (FRAME, replace(FRAME, x_m=np.nextafter(1.0, 2.0).item(), y_m=2.1), False),
        (STATE, replace(STATE, qpos=np.array([0.0, np.nextafter(1.0, 2.0), 2.0])), True),
        (STATE, replace(STATE, step=2), False),
    ],
)
def test_more_than_rounding_and_every_state_diverges_everywhere(
    logged: Message, replayed: Message, rounding: bool
) -> None:
    with pytest.raises(Diverged) as caught:
        comparator(logged, bitwise=False)(replayed)
    assert caught.value.rounding is rounding


def test_each_message_that_is_rounded_otherwise_is_counted() -> None:
    compare = comparator(FRAME, FRAME, bitwise=False)
    for _ in range(2):
        compare(replace(FRAME, x_m=np.nextafter(1.0, 2.0).item()))
    assert compare.rounded == {"/telemetry": 2}


def test_before_the_first_state_it_is_mission_start() -> None:
    with pytest.raises(Diverged) as caught:
        comparator(EVENT)(replace(EVENT, text="driving on"))
    assert (caught.value.where.step, caught.value.where.time_ns) == (0, 0)


def test_a_message_of_another_kind_diverges() -> None:
    with pytest.raises(Diverged) as caught:
        comparator(EVENT)(STATE)
    where = caught.value.where
    assert (where.topic, where.component, where.logged, where.replayed) == ("/event", "type", "Event", "State")
