"""What a request says, and the ground station that a mission file asks for."""

from __future__ import annotations

from typing import Any, NoReturn

import pytest

from tests.flight.operator.missions import mission_of
from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.frames import UP, LoggedDirection
from waypointctl.flight.link.impairments import fixed_delay
from waypointctl.flight.operator.joint import JointOperator
from waypointctl.flight.operator.operator import Operator
from waypointctl.flight.operator.planner import MissionOperator, ShortRangeGoalOperator, WaypointOperator
from waypointctl.flight.operator.requests import CommandRequest
from waypointctl.flight.operator.station import station_for
from waypointctl.log.messages import CommandKind
from waypointctl.units import NS_PER_S


def no_joint() -> NoReturn:
    raise AssertionError("the pilot is for autonomy joint")


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
    made = station_for(mission_of(""), no_joint, lambda _: None, uplink, Direction(), 20)
    assert made.heartbeats.next_ns is None
