"""What the ground knows of a flight has arrived there: nothing that is true on board alone."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from tests.replay.rewriting import Flown, fly_once
from waypointctl.flight.operator.requests import planned_waypoints
from waypointctl.log.header import MissionSetting
from waypointctl.log.messages import Message, PlannedWaypoint, State, Telemetry
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.legs import WaypointStatus
from waypointctl.replay.summary_builder import OperatorView


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Flown:
    folder = tmp_path_factory.mktemp("flight")
    return fly_once(folder, make_policy(folder / "policy", seed=7))


def known(messages: list[Message], waypoints: tuple[PlannedWaypoint, ...]) -> OperatorView:
    flight = OperatorView(waypoints, MissionSetting())
    for message in messages:
        flight(message)
    return flight


def test_a_waypoint_is_reached_from_when_telemetry_says_so(flown: Flown) -> None:
    messages, plan = flown.messages, planned_waypoints(flown.mission_file.mission)
    first = next(at for at, it in enumerate(messages) if isinstance(it, Telemetry) and it.reached)
    fates = [[it.status for it in known(messages[:end], plan).flight.waypoints] for end in (first, first + 1)]
    assert fates == [[WaypointStatus.OPEN] * 3, [WaypointStatus.REACHED, WaypointStatus.OPEN, WaypointStatus.OPEN]]


def test_the_way_is_where_telemetry_has_seen_the_robot(flown: Flown) -> None:
    flight = known(flown.messages, ()).flight
    frames = [message for message in flown.messages if isinstance(message, Telemetry)]
    assert flight.belief(10_000).x_m.tolist() == [frame.x_m for frame in frames]
    assert len(flight.truth(10_000)) == 0
    assert flight.state is None


def test_what_is_true_on_board_alone_changes_nothing(flown: Flown) -> None:
    heard = [it for it in flown.messages if not isinstance(it, State | Telemetry)]
    flight = known([*heard, next(it for it in flown.messages if isinstance(it, State))], ()).flight
    assert all(command.onboard is None for command in flight.commands)
    assert all(event.clock.value == "operator" for event in flight.events)


def test_time_passes_though_nothing_is_heard(flown: Flown) -> None:
    flight = known(flown.messages, ())
    heard_ns = flight.now_ns
    flight.pass_time(heard_ns + 5)
    flight.pass_time(heard_ns)
    assert flight.now_ns == flight.flight.now_ns == heard_ns + 5
