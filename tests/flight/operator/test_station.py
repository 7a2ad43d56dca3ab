"""The ground as a whole: what it sends when, and when it has finished."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NoReturn

import numpy as np
import pytest

from tests.flight.operator.channel import ROUND_TRIP_NS, Channel, ground
from tests.flight.operator.missions import ack, frame, mission_of
from waypointctl.flight.link.direction import Delivery, Direction
from waypointctl.flight.link.frames import UP, BodyFrame, Heartbeat, LoggedDirection
from waypointctl.flight.link.impairments import fixed_delay
from waypointctl.flight.operator.joint import JointOperator
from waypointctl.flight.operator.operator import Operator
from waypointctl.flight.operator.planner import MissionOperator, ShortRangeGoalOperator, WaypointOperator
from waypointctl.flight.operator.requests import CommandRequest, scheduled_requests
from waypointctl.flight.operator.station import HeartbeatSender, Station, station_for
from waypointctl.log.messages import CommandKind, CommandStatus, Stage
from waypointctl.units import NS_PER_S


def no_uplink(now_ns: int, make: object) -> NoReturn:
    raise AssertionError("nothing is to be sent")


def station(text: str = "", *, acknowledged: bool = True, period_ns: int = 0) -> tuple[Station, Channel]:
    mission, channel = mission_of(text), Channel()
    dispatcher, _ = ground(channel, acknowledged=acknowledged)
    heartbeats = HeartbeatSender(channel, period_ns)
    operator = WaypointOperator(mission)
    return Station(operator, scheduled_requests(mission), dispatcher, heartbeats, lambda sent_ns: sent_ns), channel


def sent(channel: Channel) -> list[CommandKind]:
    return [command.kind for command in channel.arrived if not isinstance(command, Heartbeat)]


def end_mission(ground_station: Station) -> None:
    """Bring the ends of both legs, and a frame that is as new."""
    ground_station.begin()
    for command_id in (1, 2):
        ground_station.on_message(10, ack(Stage.COMPLETED, command_id, issued_ns=5))
    ground_station.on_message(10, frame(issued_ns=5))


# The end


def test_it_has_finished_when_nothing_is_left_to_send_or_to_receive() -> None:
    done, _ = station()
    assert not done.finished
    end_mission(done)
    assert done.finished
    done.console_is_open = True
    assert not done.finished, "a person may still send something"


def test_what_is_scheduled_or_unacknowledged_keeps_it_from_finishing() -> None:
    scheduled, channel = station("schedule: [{at: 9 s, do: hold}]")
    end_mission(scheduled)
    assert not scheduled.finished
    scheduled.wake(9 * NS_PER_S)
    assert sent(channel)[-1] is CommandKind.HOLD
    assert not scheduled.finished, "its acknowledgement is awaited"
    scheduled.on_message(10 * NS_PER_S, ack(Stage.COMPLETED, 3, issued_ns=5))
    assert scheduled.finished


def test_an_end_without_a_frame_as_new_keeps_it_from_finishing() -> None:
    late, _ = station()
    late.begin()
    for command_id in (1, 2):
        late.on_message(10, ack(Stage.COMPLETED, command_id, issued_ns=5))
    assert not late.finished
    late.on_message(20, frame(issued_ns=5))
    assert late.finished


@pytest.mark.parametrize("console_is_open", [False, True])
def test_a_fall_ends_it_whatever_is_left(console_is_open: bool) -> None:
    fallen, _ = station("schedule: [{at: 9 s, do: hold}]")
    fallen.console_is_open = console_is_open
    fallen.begin()
    fallen.on_message(10, ack(Stage.FAILED, reason="fall", issued_ns=5))
    assert fallen.operator.failure == "fall"
    assert fallen.finished


# Times


def test_it_wakes_for_what_comes_first() -> None:
    waking, _ = station("operator: {think: 5 us}\nschedule: [{at: 9 us, do: hold}]", period_ns=10_000)
    assert (waking.wake_ns, waking.is_idle) == (9_000, False)
    waking.begin()
    waking.on_message(100, ack(Stage.COMPLETED))
    waking.dispatcher.wake(1000)
    assert waking.wake_ns == 5_100, "the think time is over"
    waking.wake(5_100)
    waking.dispatcher.wake(5_100)
    assert waking.wake_ns == 5_100 + 10 + ROUND_TRIP_NS, "no acknowledgement by then"
    waking.on_message(6_000, ack(Stage.RECEIVED, 2))
    waking.wake(9_000)
    waking.on_message(9_100, ack(Stage.RECEIVED, 3))
    waking.dispatcher.wake(9_100)
    assert (waking.wake_ns, waking.is_idle) == (10_000, True), "but for the heartbeat"


@pytest.mark.parametrize("busy", ["schedule", "operator", "dispatcher"])
def test_it_is_idle_when_none_of_its_parts_wants_to_send(busy: str) -> None:
    text = {"schedule": "schedule: [{at: 9 s, do: hold}]", "operator": "operator: {think: 5 s}"}.get(busy, "")
    part, _ = station(text)
    assert part.is_idle is (busy != "schedule")
    if busy == "operator":
        part.begin()
        part.dispatcher.wake(1000)
        part.on_message(1000, ack(Stage.COMPLETED))
        assert (part.dispatcher.wake_ns, part.is_idle) == (None, False)
    if busy == "dispatcher":
        part.begin()
        assert not part.is_idle


def test_heartbeats_are_numbered_and_come_a_period_apart() -> None:
    beats: list[Heartbeat] = []

    def uplink(now_ns: int, make: Any) -> Delivery:
        beats.append(make(now_ns + 7))
        return Delivery(now_ns, now_ns, (now_ns + 7,), "")

    sender = HeartbeatSender(uplink, 100)
    for now_ns in (0, 99, 100, 101, 199, 200):
        sender.send_due(now_ns)
    assert beats == [Heartbeat(0, 100, 107), Heartbeat(1, 200, 207)]
    assert (sender.beats, sender.next_ns) == (2, 300)
    never = HeartbeatSender(no_uplink, 0)
    never.send_due(10**18)
    assert never.next_ns is None


# What goes to the operator


def test_an_end_is_reported_to_the_operator_once() -> None:
    once, channel = station()
    once.begin()
    for _ in range(2):
        once.on_message(10, ack(Stage.COMPLETED))
    assert sent(channel) == [CommandKind.GO_TO] * 2


def test_an_end_that_telemetry_reported_is_one() -> None:
    once, channel = station()
    once.begin()
    status = replace(frame(), commands=(CommandStatus(1, Stage.COMPLETED),))
    once.on_message(10, status)
    once.wake(110)
    assert sent(channel) == [CommandKind.GO_TO] * 2


def test_what_others_send_reaches_the_operator_only_while_it_leads() -> None:
    text = "autonomy: short_range_goal\nschedule: [{at: 1 s, do: hold}, {at: 2 s, do: resume}]"
    mission = mission_of(text)
    for finished in (False, True):
        dispatcher, _ = ground(Channel())
        operator = ShortRangeGoalOperator(mission)
        heartbeats = HeartbeatSender(no_uplink, 0)
        led = Station(operator, scheduled_requests(mission), dispatcher, heartbeats, lambda sent_ns: sent_ns)
        operator.finished = finished
        led.wake(NS_PER_S)
        assert operator.suspended is not finished
        assert operator.newest == (), "it is not the operator's own"
        assert operator._kinds == {1: CommandKind.HOLD}


def test_an_operator_that_has_finished_sends_nothing_more() -> None:
    thinking, channel = station("operator: {think: 5 s}")
    thinking.begin()
    thinking.on_message(10, ack(Stage.COMPLETED))
    thinking.operator.finished = True
    thinking.wake(6 * NS_PER_S)
    assert len(channel.arrived) == 1


def test_only_the_ground_that_computes_actions_answers_a_state() -> None:
    other, _ = station()
    assert other.on_state(0, BodyFrame(0, np.zeros(15), np.zeros(14), 0, 0)) is None


def test_the_newest_command_without_a_report_is_named() -> None:
    quiet, _ = station()
    assert quiet.missing == ""
    quiet.begin()
    assert quiet.missing == "no acknowledgement of command 1 (go_to WP1)"
    quiet.on_message(10, ack(Stage.COMPLETED))
    assert quiet.missing == "no acknowledgement of command 2 (go_to WP2)"


def test_its_state_has_what_it_will_send() -> None:
    given, _ = station("schedule: [{at: 9 s, do: release, released: 2}]")
    given.begin()
    assert given.state() == {
        "operator": {"finished": False, "queue": []},
        "commands": {"issued": 1, "open": [[1, 1, "queued", 10 + ROUND_TRIP_NS]], "unanswered": []},
        "scheduled": [[9 * NS_PER_S, "release 2"]],
        "heartbeats": 0,
    }


def test_a_request_leaves_open_what_its_kind_does_not_need() -> None:
    command = CommandRequest(CommandKind.HOLD).command(4, 2, 10, 20)
    assert (command.id, command.attempt, command.issued_ns, command.received_ns) == (4, 2, 10, 20)
    assert (command.released, command.target_id, command.value) == (-1, -1, 0.0)
    assert (command.not_before_ns, command.expires_ns) == (-1, -1)


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        (CommandRequest(CommandKind.RELEASE), "release all"),
        (CommandRequest(CommandKind.RELEASE, released=0), "release 0"),
        (CommandRequest(CommandKind.CANCEL, target_id=7), "cancel command 7"),
        (CommandRequest(CommandKind.SET_TOLERANCE, value=0.5), "set_tolerance 0.5 m"),
        (CommandRequest(CommandKind.SET_TIMEOUT, value=30.0), "set_timeout 30 s"),
        (CommandRequest(CommandKind.HOLD), "hold"),
    ],
)
def test_a_request_is_described_by_what_it_changes(request_: CommandRequest, words: str) -> None:
    assert request_.words == words


# From the mission file


@pytest.mark.parametrize(
    ("autonomy", "kind"),
    [
        ("mission", MissionOperator),
        ("waypoint", WaypointOperator),
        ("short_range_goal", ShortRangeGoalOperator),
        ("joint", JointOperator),
    ],
)
def test_the_autonomy_decides_who_commands(autonomy: str, kind: type[Operator]) -> None:
    pilot = JointOperator.__new__(JointOperator)
    text = f"autonomy: {autonomy}\noperator: {{heartbeat: 250 ms}}\ncommands: {{margin: 3 us}}"
    uplink: LoggedDirection[Any] = LoggedDirection(Direction(delay=fixed_delay(1000)), UP, lambda _: None)
    made = station_for(mission_of(text), lambda: pilot, lambda _: None, uplink, Direction(delay=fixed_delay(500)), 20)
    assert type(made.operator) is kind
    assert (made.operator is pilot) is (autonomy == "joint")
    assert made.heartbeats.next_ns == NS_PER_S // 4
    command_id = made.dispatcher.issue(0, CommandRequest(CommandKind.HOLD))
    assert made.dispatcher.state()["open"] == [[command_id, 1, "queued", 1000 + 20 + 500 + 3000]]


def test_without_a_period_no_heartbeat_is_sent() -> None:
    uplink: LoggedDirection[Any] = LoggedDirection(Direction(), UP, lambda _: None)
    made = station_for(mission_of(""), no_uplink, lambda _: None, uplink, Direction(), 20)  # type: ignore[arg-type]
    assert made.heartbeats.next_ns is None
