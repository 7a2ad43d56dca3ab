"""The operator who computes every action on the ground, state by state, without a flight."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.flight.flying import FloatArray, Scripted
from tests.flight.operator.missions import ack, frame, mission_of
from waypointctl.flight.executive.rules import AT_HOME
from waypointctl.flight.link.frames import BodyFrame
from waypointctl.flight.operator.joint import JointOperator
from waypointctl.flight.operator.requests import CommandRequest
from waypointctl.log.messages import TELEOPERATION, CommandKind, Event, EventKind, Mode, Stage
from waypointctl.robots.load import load_robot
from waypointctl.task.plugins import ObservationGroup
from waypointctl.task.view import SimulationView
from waypointctl.units import NS_PER_S

ACTION = np.linspace(-0.5, 0.5, 8)
PERIOD_NS = 20_000_000
BODY = BodyFrame(0, np.array([0.0, 0.0, 0.5, 1.0, *[0.0] * 11]), np.zeros(14), 0, 0)


class Ground:
    """An operator, and the states that it gets."""

    def __init__(self, text: str = "", waypoints: str = "[[4, 0], [4, 3]]") -> None:
        self.events: list[Event] = []
        mission = mission_of(f"autonomy: joint\n{text}", waypoints)
        self.operator = JointOperator(mission, Scripted(ACTION), load_robot("ant"), np.zeros(4), (), self.events.append)
        assert self.operator.begin() == []

    def state(self, issued_ns: int, x_m: float = 0.0, y_m: float = 0.0) -> tuple[bool, list[CommandKind]]:
        """Bring a state; return whether an action answers it, and the kinds of what else is sent."""
        qpos = np.array([x_m, y_m, 0.5, 1.0, *[0.0] * 11])
        body = BodyFrame(issued_ns // PERIOD_NS, qpos, np.zeros(14), issued_ns, issued_ns + 5)
        control, requests = self.operator.on_state(issued_ns + 5, body)
        for number, request in enumerate(requests, 1):
            self.operator.on_issued(number, request)
        if control is not None:
            assert (control.time_ns, control.step, control.issued_ns) == (issued_ns + 5, body.step, issued_ns)
            assert np.array_equal(control.commanded, ACTION)
        return control is not None, [request.kind for request in requests]

    @property
    def kinds(self) -> list[EventKind]:
        return [event.kind for event in self.events]


def test_each_state_is_answered_until_the_last_waypoint_is_reached() -> None:
    ground = Ground()
    assert ground.operator.acts_on_states
    assert ground.state(0, 4.0, 0.0) == (True, []), "a leg is judged after its first control period"
    assert not ground.operator.reached
    assert ground.state(PERIOD_NS, 4.0, 0.0) == (True, [])
    assert list(ground.operator.reached) == [0]
    assert ground.state(2 * PERIOD_NS, 4.0, 3.0) == (False, [CommandKind.HOLD])
    assert list(ground.operator.reached) == [0, 1]
    assert (ground.operator.finished, ground.operator.failure) == (True, "")
    assert ground.state(3 * PERIOD_NS, 4.0, 3.0) == (False, [])
    assert not ground.operator.acts_on_states
    assert ground.kinds == [EventKind.WAYPOINT_REACHED] * 2


def test_its_own_hold_stops_teleoperation_alone() -> None:
    ground = Ground("defaults: {timeout: 5 s}")
    _, requests = ground.operator.on_state(5 * NS_PER_S, replace(BODY, issued_ns=5 * NS_PER_S))
    assert requests == [CommandRequest(CommandKind.HOLD, target_id=TELEOPERATION)]


def test_a_hold_on_the_way_is_waited_for_on_the_robots_clock() -> None:
    ground = Ground("defaults: {timeout: 5 s}", "[{position_m: [4, 0], hold: 2 s}, [4, 3]]")
    assert ground.state(NS_PER_S, 4.0, 0.0) == (False, [CommandKind.HOLD])
    assert ground.state(3 * NS_PER_S - 1, 4.0, 0.0) == (False, [])
    assert ground.state(3 * NS_PER_S, 4.0, 0.0) == (True, [])
    assert ground.state(8 * NS_PER_S - 1, 4.0, 0.0) == (True, []), "the hold is no time of the leg"
    assert ground.state(8 * NS_PER_S, 4.0, 0.0) == (False, [CommandKind.HOLD])
    assert (ground.operator.finished, ground.operator.failure) == (True, "timeout")


@pytest.mark.parametrize(
    ("stage", "reason", "skips", "goes_on"),
    [
        (Stage.COMPLETED, "", False, True),
        (Stage.FAILED, "timeout", False, False),
        (Stage.FAILED, "timeout", True, True),
        (Stage.FAILED, "fall", True, False),
        (Stage.REJECTED, "geofence", True, False),
    ],
)
def test_a_task_is_handed_over_and_its_end_waited_for(stage: Stage, reason: str, skips: bool, goes_on: bool) -> None:
    text = "on_failure: skip" if skips else ""
    ground = Ground(text, "[{position_m: [4, 0], observe: true}, [4, 3]]")
    assert ground.state(NS_PER_S, 4.0, 0.0) == (False, [CommandKind.GO_TO])
    assert ground.state(2 * NS_PER_S, 4.0, 0.0) == (False, [])
    assert not ground.operator.acts_on_states
    assert ground.operator.on_message(0, ack(Stage.COMPLETED, 7)) == [], "another command's end"
    assert ground.state(2 * NS_PER_S, 4.0, 0.0) == (False, [])
    ground.operator.on_message(0, ack(stage, 1, reason, issued_ns=3 * NS_PER_S))
    assert ground.state(3 * NS_PER_S, 4.0, 3.0) == (goes_on, []), "at the next waypoint, in the leg's first period"
    assert ground.operator.finished is not goes_on
    assert ground.operator.failure == ("" if goes_on else reason)


def test_a_leg_out_of_time_is_skipped_where_the_mission_says_so() -> None:
    ground = Ground("on_failure: skip\ndefaults: {timeout: 5 s}")
    assert ground.state(5 * NS_PER_S - 1) == (True, [])
    assert ground.state(5 * NS_PER_S) == (True, [])
    assert ground.kinds == [EventKind.WAYPOINT_TIMEOUT, EventKind.WAYPOINT_SKIPPED]
    assert ground.state(6 * NS_PER_S, 4.0, 3.0) == (False, [CommandKind.HOLD])
    assert (ground.operator.reached, ground.operator.failure) == ((1,), "")


def test_a_robot_that_a_rule_has_sent_home_is_not_stopped() -> None:
    ground = Ground("defaults: {timeout: 5 s}")
    home = replace(frame(mode=Mode.RETURNING), cause=AT_HOME + "link lost")
    ground.operator.on_message(0, home)
    assert ground.state(5 * NS_PER_S) == (False, [])
    assert ground.operator.failure == "link lost"


def test_a_reported_fall_ends_the_mission_and_another_mode_does_not() -> None:
    ground = Ground()
    ground.operator.on_message(0, frame(mode=Mode.TELEOPERATED))
    assert not ground.operator.finished
    ground.operator.on_message(0, replace(frame(mode=Mode.FALLEN), frame=1))
    assert (ground.operator.finished, ground.operator.failure) == (True, "fall")


@pytest.mark.parametrize("kind", [CommandKind.HOLD, CommandKind.RETURN_HOME])
def test_no_action_is_sent_after_a_hold_until_it_is_resumed_nor_after_a_way_home(kind: CommandKind) -> None:
    ground = Ground()
    ground.operator.note_kind(9, kind)
    ground.operator.on_external_request(0, CommandRequest(kind))
    assert ground.state(NS_PER_S) == (False, [])
    assert not ground.operator.acts_on_states
    if kind is CommandKind.RETURN_HOME:
        ground.operator.on_message(0, ack(Stage.COMPLETED, 9))
        assert ground.operator.finished
    else:
        ground.operator.on_external_request(0, CommandRequest(CommandKind.RESUME))
        assert ground.state(NS_PER_S) == (True, [])


def test_a_cause_that_no_rule_on_board_gave_is_not_why_the_mission_failed() -> None:
    ground = Ground("defaults: {timeout: 5 s}")
    ground.operator.on_message(0, replace(frame(mode=Mode.PAUSED), cause="by command 3"))
    assert ground.state(5 * NS_PER_S) == (False, [CommandKind.HOLD])
    assert ground.operator.failure == "timeout"


def test_a_state_is_answered_with_the_goals_the_time_and_the_last_action() -> None:
    def seen(view: SimulationView) -> FloatArray:
        return np.column_stack([view.goals.reshape(1, 4), view.steps, view.action])

    numbers = tuple(f"number {number}" for number in range(13))
    group = ObservationGroup("all_of_it", seen, numbers, "1", 1.0)
    policy = Scripted(2 * ACTION)
    policy.observation_layout = ("all_of_it",)  # type: ignore[assignment]
    mission = mission_of("autonomy: joint", "[[4, 0], [4, 3], [1, 3]]")
    operator = JointOperator(mission, policy, load_robot("ant"), np.zeros(4), (group,), lambda _: None)

    def observed(step: int, x_m: float, y_m: float) -> list[float]:
        qpos = np.array([x_m, y_m, 0.5, 1.0, *[0.0] * 11])
        control, _ = operator.on_state(0, BodyFrame(step, qpos, np.zeros(14), step * PERIOD_NS, 0))
        assert control is not None
        observation: list[float] = control.observation.tolist()
        return observation

    assert observed(3, 0.0, 0.0) == [4.0, 0.0, 4.0, 3.0, 3.0, *[0.0] * 8]
    assert observed(4, 4.0, 0.0) == [4.0, 3.0, 1.0, 3.0, 4.0, *np.clip(2 * ACTION, -1, 1)]
    assert observed(5, 4.0, 3.0)[:4] == [1.0, 3.0, 1.0, 3.0]
    assert operator.reached == (0, 1)
    assert operator.state()["leg"] == 2


def test_a_fall_during_a_task_stays_the_reason() -> None:
    ground = Ground("", "[{position_m: [4, 0], observe: true}]")
    assert "at_task" not in ground.operator.state()
    assert ground.state(NS_PER_S, 4.0, 0.0) == (False, [CommandKind.GO_TO])
    assert ground.operator.state()["at_task"] is True
    ground.operator.on_message(0, frame(mode=Mode.FALLEN))
    ground.operator.on_message(0, ack(Stage.COMPLETED, 1))
    assert ground.operator.failure == "fall"


def test_a_fall_ends_the_mission_whichever_command_reports_it() -> None:
    ground = Ground()
    ground.operator.on_message(0, ack(Stage.CANCELLED, 9, "fall"))
    assert (ground.operator.finished, ground.operator.failure) == (True, "fall")
