"""One leg: when it is assessed, how far it is, and what counts as getting closer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.flight.executive.rig import SECOND, A, B, Rig
from waypointctl.flight.executive.plan import Leg
from waypointctl.flight.executive.rules import home_at
from waypointctl.log.messages import Mode, PlannedWaypoint

MINUTE = 60 * SECOND


def test_a_leg_is_assessed_after_its_first_control_period() -> None:
    rig = Rig()
    rig.command(0.0, A)
    assert rig.sense(0.0, "a") is Mode.NAVIGATING
    assert rig.sense(0.02, "a") is Mode.DONE


@pytest.mark.parametrize(("place", "distance_m"), [((5.0, 4.0), 1.0), ((1.0, 2.0), 5.0)])
def test_the_distance_is_that_in_the_plane(place: tuple[float, float], distance_m: float) -> None:
    assert Leg(B, B, 0).distance_m(np.array([[*place, 0.7]])) == distance_m


def test_the_stopped_tolerance_is_inclusive() -> None:
    rig = Rig(slip_m=1.0, stall_ns=5 * SECOND)
    rig.command(0.0, replace(A, timeout_ns=MINUTE))
    rig.sense(1.0, (4.0, 0.0))
    assert rig.sense(6.0, (4.0, 0.0)) is Mode.DONE


def test_a_decrease_by_exactly_the_least_progress_is_progress() -> None:
    rig = Rig(stuck_fails=True, progress_m=0.5, stall_ns=5 * SECOND)
    rig.command(0.0, replace(A, timeout_ns=MINUTE))
    rig.sense(1.0, "start")
    rig.sense(5.0, (0.5, 0.0))
    assert rig.sense(9.98, (0.5, 0.0)) is Mode.NAVIGATING
    assert rig.sense(10.0, (0.5, 0.0)) is Mode.FAILED


@pytest.mark.parametrize(("rules", "best_m"), [({}, None), ({"slip_m": 1.0}, 4.0), ({"stuck_fails": True}, 4.0)])
def test_progress_is_measured_only_where_a_rule_needs_it(rules: dict[str, object], best_m: float | None) -> None:
    rig = Rig(**rules)
    rig.command(0.0, A)
    rig.sense(1.0, (1.0, 0.0))
    leg = rig.executive.state()["leg"]
    assert isinstance(leg, dict)
    assert leg["best_m"] == best_m


def test_home_is_no_waypoint_of_the_mission_and_nothing_is_done_there() -> None:
    assert home_at(1.0, 2.0) == PlannedWaypoint(-1, "home", 1.0, 2.0, "radius", 0.5, 300 * SECOND, 0, "")
