"""The ground as a whole: what it sends when, and when it has finished."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NoReturn

import numpy as np
import pytest

from tests.flight.flying import STILL, Scripted
from tests.flight.operator.channel import ROUND_TRIP_NS, Channel, ground
from tests.flight.operator.missions import ack, frame, mission_of
from waypointctl.flight.link.direction import Delivery
from waypointctl.flight.link.frames import BodyFrame, Heartbeat
from waypointctl.flight.operator.joint import JointOperator
from waypointctl.flight.operator.planner import ShortRangeGoalOperator, WaypointOperator
from waypointctl.flight.operator.requests import CommandRequest, scheduled_requests
from waypointctl.flight.operator.station import HeartbeatSender, Station
from waypointctl.log.messages import CommandKind, CommandStatus, Stage
from waypointctl.robots.load import load_robot
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
    once, channel = station("operator: {think: 5 s}")
    once.begin()
    for stage in (Stage.RECEIVED, Stage.COMPLETED, Stage.COMPLETED):
        once.on_message(10, ack(stage))
    once.wake(6 * NS_PER_S)
    assert sent(channel) == [CommandKind.GO_TO] * 2
    once.on_message(7 * NS_PER_S, ack(Stage.COMPLETED, 2))
    assert once.operator.finished, "what was thought of is the operator's own"


def test_a_goal_that_a_hold_kept_back_is_the_operators_own() -> None:
    mission = mission_of("autonomy: short_range_goal\nschedule: [{at: 1 s, do: hold}, {at: 2 s, do: resume}]")
    dispatcher, _ = ground(Channel())
    operator = ShortRangeGoalOperator(mission)
    heartbeats = HeartbeatSender(no_uplink, 0)
    led = Station(operator, scheduled_requests(mission), dispatcher, heartbeats, lambda sent_ns: sent_ns)
    led.begin()
    led.wake(NS_PER_S)
    led.on_message(NS_PER_S, ack(Stage.COMPLETED))
    led.wake(2 * NS_PER_S)
    assert operator.newest == (4,)


def piloted(channel: Channel, arrival_ns: Callable[[int], int]) -> Station:
    mission = mission_of("autonomy: joint", "[{position_m: [4, 0], hold: 2 s}, [4, 3]]")
    pilot = JointOperator(mission, Scripted(STILL), load_robot("ant"), np.zeros(4), (), lambda _: None)
    dispatcher, _ = ground(channel)
    return Station(pilot, scheduled_requests(mission), dispatcher, HeartbeatSender(channel, 0), arrival_ns)


def body(x_m: float, issued_ns: int) -> BodyFrame:
    return BodyFrame(1, np.array([x_m, 0.0, 0.5, 1.0, *[0.0] * 11]), np.zeros(14), issued_ns, issued_ns)


def test_what_a_state_makes_the_pilot_send_is_its_own() -> None:
    channel = Channel()
    flown = piloted(channel, lambda sent_ns: sent_ns)
    assert flown.on_state(NS_PER_S, body(0.0, NS_PER_S)) is not None
    assert flown.on_state(2 * NS_PER_S, body(4.0, 2 * NS_PER_S)) is None
    assert sent(channel) == [CommandKind.HOLD]
    assert (flown.operator.newest, flown.operator.suspended) == ((1,), False)


@pytest.mark.parametrize("how", ["message", "state", "wake"])
def test_it_leads_no_further_once_what_it_sends_would_arrive_after_a_return_home_begins(how: str) -> None:
    led = piloted(Channel(), lambda sent_ns: sent_ns + 50)
    led.issue(0, [CommandRequest(CommandKind.RETURN_HOME, not_before_ns=100)])
    for now_ns in (49, 50):
        assert not led.operator.going_home
        if how == "message":
            led.on_message(now_ns, frame())
        elif how == "state":
            led.on_state(now_ns, body(0.0, now_ns))
        else:
            led.wake(now_ns)
    assert led.operator.going_home


def test_a_heartbeat_is_sent_when_it_is_due() -> None:
    beating, channel = station(period_ns=100)
    beating.wake(99)
    assert channel.arrived == []
    beating.wake(100)
    assert len(channel.arrived) == 1


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
