"""What telemetry tells of commands counts as heard."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.flight.operator.channel import AIRTIME_NS, HOLD, Channel, ack, frame, ground
from waypointctl.log.messages import Ack, CommandStatus, Event, EventKind, Mode, Stage, Telemetry


def told(*statuses: CommandStatus, at_ns: int, mode: Mode = Mode.NAVIGATING) -> Telemetry:
    return replace(frame(mode), issued_ns=at_ns, received_ns=at_ns, commands=statuses)


def test_a_command_that_telemetry_names_is_not_sent_again() -> None:
    channel = Channel()
    dispatcher, _ = ground(channel, retries=3)
    dispatcher.issue(0, HOLD)
    dispatcher.wake(AIRTIME_NS)
    dispatcher.on_message(1500, told(CommandStatus(1, Stage.STARTED), at_ns=1400))
    assert dispatcher.wake_ns is None
    assert dispatcher.awaits


def test_an_end_that_telemetry_tells_is_known_once_its_acknowledgement_might_have_come() -> None:
    channel = Channel()
    dispatcher, events = ground(channel)
    dispatcher.issue(0, HOLD)
    dispatcher.wake(AIRTIME_NS)
    ended = CommandStatus(1, Stage.FAILED, "stuck")
    dispatcher.on_message(1500, told(ended, at_ns=1400))
    dispatcher.on_message(1550, told(ended, at_ns=1450, mode=Mode.DONE))
    assert dispatcher.wake_ns == 1600, "a second frame does not put it off"
    assert dispatcher.wake(1599) == []
    assert dispatcher.wake(1600) == [Ack(1, Stage.FAILED, "stuck", 1400, 1500)]
    assert not dispatcher.awaits
    assert [one.text for one in events if isinstance(one, Event) and one.kind is EventKind.COMMAND_KNOWN] == [
        "command 1 is known from telemetry to be failed (stuck)"
    ]
    assert len(channel.arrived) == 1


def test_an_acknowledgement_that_comes_in_time_goes_before_the_frame() -> None:
    dispatcher, events = ground(Channel())
    dispatcher.issue(0, HOLD)
    dispatcher.wake(AIRTIME_NS)
    dispatcher.on_message(1500, told(CommandStatus(1, Stage.COMPLETED), at_ns=1400))
    dispatcher.on_message(1500, ack(Stage.COMPLETED))
    assert dispatcher.wake_ns is None
    assert not [one for one in events if isinstance(one, Event) and one.kind is EventKind.COMMAND_KNOWN]


@pytest.mark.parametrize("late", [ack(Stage.STARTED), told(CommandStatus(1, Stage.STARTED), at_ns=9000)])
def test_a_command_is_unknown_after_its_last_retry_until_anything_is_heard_of_it(late: Ack | Telemetry) -> None:
    dispatcher, _ = ground(Channel(lose=[True] * 9), retries=1)
    dispatcher.issue(0, HOLD)
    while dispatcher.wake_ns is not None:
        dispatcher.wake(dispatcher.wake_ns)
    assert dispatcher.missing(1) == "no acknowledgement of command 1 (hold)"
    dispatcher.on_message(9100, late)
    assert dispatcher.unanswered == ()
    assert dispatcher.missing(1) == "no final stage received for command 1 (hold); its last known stage is started"
    dispatcher.on_message(9200, ack(Stage.COMPLETED))
    assert dispatcher.missing(1) == ""


@pytest.mark.parametrize("retries", [0, 1, 3])
def test_what_is_asked_for_once_more_counts_as_a_retry(retries: int) -> None:
    channel = Channel()
    dispatcher, _ = ground(channel, retries)
    dispatcher.issue(0, HOLD)
    dispatcher.on_message(1500, ack(Stage.STARTED))
    for now_ns in range(2000, 60_000, 500):
        dispatcher.on_message(now_ns, told(at_ns=now_ns - 1, mode=Mode.DONE))
        dispatcher.wake(now_ns)
    assert [command.attempt for command in channel.arrived] == list(range(1, retries + 2))
    assert dispatcher.unanswered == (), "something was heard of it"
