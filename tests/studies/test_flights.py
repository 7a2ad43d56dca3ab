from __future__ import annotations

import numpy as np
import pytest

from waypointctl.flight.outcome import FlightResult
from waypointctl.log.messages import Ack, Action, Clock, Event, EventKind, Message, Severity, Stage, State
from waypointctl.replay.summary_builder import summarize
from waypointctl.studies.case import DelayCase
from waypointctl.studies.flights import measured

S = 1_000_000_000
DONE = FlightResult("success", "2 of 2", 2, 2, 10 * S, 10 * S, 0)


def state(time_s: float, x_m: float, y_m: float, vx_mps: float, vy_mps: float = 0.0) -> State:
    qpos, qvel = np.zeros(15), np.zeros(14)
    qpos[:2], qvel[:2] = (x_m, y_m), (vx_mps, vy_mps)
    return State(round(time_s * S), 0, qpos, qvel, np.zeros(14))


def case(autonomy: str = "waypoint") -> DelayCase:
    return DelayCase("r", autonomy, 2.56, 3)


def test_distance_is_that_of_the_way_and_standing_is_time_of_little_speed() -> None:
    messages: list[Message] = [
        Action(0, 0, "policy", np.zeros(8), np.zeros(8)),
        state(0.0, 0, 0, 0.0),
        state(1.0, 0, 0, 0.049),  # stands until 3
        state(3.0, 3, 4, 0.03, 0.04),  # walks: not below 0.05
        state(4.0, 3, 5, 1.0),
        state(5.0, 3, 4, 0.0),  # stands until 9: at rest there are no states between
        state(9.0, 3, 4, 2.0),
        state(10.0, 5, 4, 0.0),
    ]
    flown = measured(case(), DONE, summarize(messages))
    assert flown.distance_m == 5 + 1 + 1 + 2
    assert flown.standing_s == 1 + 2 + 4
    assert (flown.time_s, flown.outcome, flown.case) == (10.0, "success", case())


def test_nothing_is_standing_after_the_end() -> None:
    summary = summarize([state(0.0, 0, 0, 0.0), state(10.02, 0, 0, 0.0)])
    assert measured(case(), DONE, summary).standing_s == 10.0


@pytest.mark.parametrize(
    ("autonomy", "waited"), [("waypoint", 2), ("short_range_goal", 2), ("short_range_goal-continuous", 0)]
)
def test_commands_are_waited_for_whose_end_the_operator_knows(autonomy: str, waited: int) -> None:
    stages = [(1, Stage.ACCEPTED), (1, Stage.COMPLETED), (1, Stage.COMPLETED), (2, Stage.FAILED), (3, Stage.STARTED)]
    summary = summarize(Ack(command_id, stage, "", 0, 0) for command_id, stage in stages)
    assert measured(case(autonomy), DONE, summary).exchanges == waited


def test_falls_are_counted_and_failures_are_failures() -> None:
    kinds = (EventKind.FALL, EventKind.WAYPOINT_REACHED)
    summary = summarize(Event(0, kind, Clock.ROBOT, Severity.ERROR, "") for kind in kinds)
    flown = measured(case(), FlightResult("failure", "fall", 0, 2, S, S, 0), summary)
    assert (flown.falls, flown.succeeded, flown.reason) == (1, False, "fall")
