"""The shipped missions do what their comments say that they show."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.shipped import shipped_messages
from waypointctl.flight.executive.rules import rules_of
from waypointctl.log.messages import CommandStage, Event, EventKind, GroundControl, Stage, State, Telemetry
from waypointctl.mission.files import load_mission

MISSIONS = Path(__file__).parents[2] / "missions"


def events(name: str, kind: EventKind) -> list[Event]:
    return [message for message in shipped_messages(name) if isinstance(message, Event) and message.kind is kind]


def stages(name: str, stage: Stage) -> list[CommandStage]:
    return [
        message for message in shipped_messages(name) if isinstance(message, CommandStage) and message.stage is stage
    ]


def test_there_are_enough() -> None:
    assert len(list(MISSIONS.glob("*.yaml"))) >= 10


def test_the_detour_keeps_out_of_the_crater_and_the_straight_way_would_not() -> None:
    mission = load_mission(MISSIONS / "crater-detour.yaml").mission
    fence = rules_of(mission).fence
    states = [message for message in shipped_messages("crater-detour") if isinstance(message, State)]
    assert not any(fence.breach(float(state.qpos[0]), float(state.qpos[1])) for state in states)
    assert fence.breach_between(mission.start.position_m, mission.waypoints[-1].position_m)


def test_the_lossy_link_loses_commands_and_the_robot_obeys_each_once() -> None:
    assert len(stages("lossy-link", Stage.LOST)) >= 2
    assert len(stages("lossy-link", Stage.UNKNOWN)) >= 2
    assert max(stage.attempt for stage in stages("lossy-link", Stage.QUEUED)) >= 3
    for stage in (Stage.STARTED, Stage.COMPLETED):
        assert [each.command_id for each in stages("lossy-link", stage)] == [1, 2, 3, 4]


def test_the_relay_takes_the_plan_up_in_one_contact_and_its_end_down_in_another() -> None:
    (queued,), (sent,) = (stages("contact-windows", stage) for stage in (Stage.QUEUED, Stage.SENT))
    (ended,) = events("contact-windows", EventKind.MISSION_ENDED)
    assert (queued.time_ns, sent.time_ns) == (0, 5_000_000_000)
    assert 45e9 < ended.time_ns < 53e9
    assert events("contact-windows", EventKind.PLAN_COMPLETED)[0].time_ns < 40e9


def test_the_schedule_stops_the_robot_twice() -> None:
    paused, resumed = (
        events("hold-and-resume", kind) for kind in (EventKind.NAVIGATION_PAUSED, EventKind.NAVIGATION_RESUMED)
    )
    assert len(paused) == len(resumed) == 2
    assert paused[0].time_ns == 4_280_000_000  # sent at 3 s
    assert paused[1].time_ns == 14_000_000_000  # there at 11.28 s, and not before 14 s


def test_steering_stands_most_of_the_time() -> None:
    states = np.array([state.qpos[:2] for state in shipped_messages("steered") if isinstance(state, State)])
    speeds = np.linalg.norm(np.diff(states, axis=0), axis=1) / 0.02
    assert np.mean(speeds < 0.3) > 0.5
    assert len(stages("steered", Stage.COMPLETED)) > 5


def test_the_ledge_is_tried_twice_and_skipped() -> None:
    assert len(events("retry-then-skip", EventKind.LEG_RETRIED)) == 1
    assert [event.waypoint for event in events("retry-then-skip", EventKind.WAYPOINT_SKIPPED)] == [1]


def test_each_observation_is_taken_once() -> None:
    assert [event.waypoint for event in events("observe-stops", EventKind.OBSERVATION_TAKEN)] == [0, 1, 3]


def test_the_plan_for_mars_costs_the_steps_of_its_walk_alone() -> None:
    steps = sum(isinstance(message, State) for message in shipped_messages("mars-plan"))
    (ended,) = events("mars-plan", EventKind.MISSION_ENDED)
    assert ended.time_ns > 2 * 182_000_000_000
    assert steps * 0.02 < 60


@pytest.mark.parametrize("waypoint", [1, 2])
def test_the_robot_waits_for_each_release(waypoint: int) -> None:
    awaited = events("released-in-stages", EventKind.RELEASE_AWAITED)
    started = [event for event in events("released-in-stages", EventKind.LEG_STARTED) if event.waypoint == waypoint]
    assert len(awaited) == 2
    assert started[0].time_ns == (13_280_000_000 if waypoint == 1 else 25_280_000_000)


def test_the_patrol_walks_five_of_its_six_legs() -> None:
    names = [leg.name for leg in load_mission(MISSIONS / "patrol.yaml").mission.legs()]
    assert names == ["tower (1)", "wall (1)", "gate (2)", "tower (2)", "wall (2)"]
    reached = events("patrol", EventKind.WAYPOINT_REACHED)
    assert [event.waypoint for event in reached] == [0, 1, 2, 3, 4]
    assert len(events("patrol", EventKind.HOLD_COMPLETED)) == 5


def test_the_third_waypoint_is_reached_between_two_passes_and_heard_of_in_the_second() -> None:
    reached = events("contact-plan", EventKind.WAYPOINT_REACHED)
    assert [event.time_ns < 20_000_000_000 for event in reached] == [True, True, False]
    (ended,) = events("contact-plan", EventKind.MISSION_ENDED)
    assert 45e9 + 1.3e9 < ended.time_ns < 45e9 + 1.5e9  # the contact opens, and one light time passes


def test_frames_overtake_each_other_where_the_jitter_has_a_long_tail() -> None:
    frames = [message for message in shipped_messages("long-tail") if isinstance(message, Telemetry)]
    issued = [frame.issued_ns for frame in frames]
    assert [frame.received_ns for frame in frames] == sorted(frame.received_ns for frame in frames)
    assert sum(later < earlier for earlier, later in pairwise(issued)) > 5
    assert max(frame.received_ns - frame.issued_ns for frame in frames) > 500_000_000


def test_over_a_local_network_every_action_comes_from_the_ground() -> None:
    controls = [message for message in shipped_messages("lan-joint") if isinstance(message, GroundControl)]
    assert len(controls) > 200
    assert [stage.command_id for stage in stages("lan-joint", Stage.COMPLETED)] == [1]  # the hold at the end
