from __future__ import annotations

import pytest

from tests.flight.operator.missions import mission_of
from waypointctl.errors import MissionError
from waypointctl.flight.operator.requests import CommandRequest, EventQueue, scheduled_requests
from waypointctl.log.messages import CommandKind
from waypointctl.units import NS_PER_S


def test_scheduled_commands_are_due_at_their_times_in_order() -> None:
    mission = mission_of(
        "schedule:\n"
        "- {at: 20 s, do: resume}\n"
        "- {at: 10 s, do: hold, expires: 15 s}\n"
        "- {at: 20 s, do: go_to, position: [1 m, 2 m], tolerance: 20 cm}\n"
        "- {at: 30 s, do: set_timeout, timeout: 2 min}\n"
        "- {at: 30 s, do: cancel, command: 4}\n"
    )
    queue = scheduled_requests(mission)
    assert queue.next_ns == 10 * NS_PER_S
    (hold,) = queue.due(10 * NS_PER_S)
    assert (hold.kind, hold.expires_ns) == (CommandKind.HOLD, 15 * NS_PER_S)
    resume, go_to = queue.due(20 * NS_PER_S)
    assert resume.kind is CommandKind.RESUME
    (place,) = go_to.waypoints
    assert (place.x_m, place.y_m, place.tolerance_m) == (1.0, 2.0, 0.2)
    timeout, cancel = queue.due(30 * NS_PER_S)
    assert (timeout.value, cancel.target_id) == (120.0, 4)
    assert queue.next_ns is None


@pytest.mark.parametrize(
    ("command", "request_"),
    [
        ("do: hold", CommandRequest(CommandKind.HOLD)),
        ("do: release, released: -1", CommandRequest(CommandKind.RELEASE)),
        ("do: release, released: 2", CommandRequest(CommandKind.RELEASE, released=2)),
        ("do: cancel, command: 1", CommandRequest(CommandKind.CANCEL, target_id=1)),
        ("do: set_tolerance, tolerance: 2 m", CommandRequest(CommandKind.SET_TOLERANCE, value=2.0)),
        ("do: set_timeout, timeout: 9 s", CommandRequest(CommandKind.SET_TIMEOUT, value=9.0)),
        ("do: hold, not_before: 3 s", CommandRequest(CommandKind.HOLD, not_before_ns=3 * NS_PER_S)),
        ("do: hold, expires: 3 s", CommandRequest(CommandKind.HOLD, expires_ns=3 * NS_PER_S)),
    ],
)
def test_a_scheduled_command_says_what_the_request_has(command: str, request_: CommandRequest) -> None:
    queue = scheduled_requests(mission_of(f"schedule:\n- {{at: 1 s, {command}}}"))
    assert queue.due(NS_PER_S) == [request_]


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("{at: 1 s, do: go_to}", "go_to needs 'position'"),
        ("{at: 1 s, do: hold, released: 2}", "hold does not accept 'released'"),
        ("{at: 9 s, do: hold, expires: 5 s}", "it expires at 5 s, before it can be executed"),
        ("{at: 1 s, do: dance}", "go_to"),
        ("{do: hold}", "at_s"),
    ],
)
def test_a_command_that_cannot_be_is_refused(command: str, said: str) -> None:
    with pytest.raises(MissionError, match=said):
        mission_of(f"schedule:\n- {command}")


def test_a_queue_that_is_cleared_has_nothing_due() -> None:
    queue: EventQueue[str] = EventQueue()
    queue.add(5, "later")
    queue.add(5, "later still")
    queue.add(3, "first")
    assert queue.entries() == [(3, "first"), (5, "later"), (5, "later still")]
    queue.clear()
    assert (queue.next_ns, queue.due(9)) == (None, [])
