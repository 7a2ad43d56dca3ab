"""Update the plan's execution with the robot's position and time: waypoints reached, held, observed; legs that fail."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.executive.leg import Leg, LegStatus
from waypointctl.flight.executive.plan import PlanItem
from waypointctl.flight.executive.plan_execution import BY_RULE, PlanExecution
from waypointctl.flight.executive.rules import LEG_FAILED, STUCK, TIMEOUT
from waypointctl.flight.executive.state_machine import POLICY_MODES, Signal
from waypointctl.log.messages import EventKind, Mode, Severity
from waypointctl.units import NS_PER_S, seconds

FloatArray = NDArray[np.float64]

OBSERVE: Final = "observe"
OBSERVATION_NS: Final = NS_PER_S  # how long the robot stops for a picture

_CODES: Final = {LegStatus.OUT_OF_TIME: TIMEOUT, LegStatus.STUCK: STUCK}


def update_leg(execution: PlanExecution, now_ns: int, position: FloatArray, heading_rad: float) -> None:
    """Look at where the robot is, position (1, >= 2) [m], and take what follows from it."""
    if execution.mode in POLICY_MODES:
        _update_leg(execution, now_ns, position)
    elif execution.mode is Mode.HOLDING:
        _update_hold(execution, now_ns)
    elif execution.mode is Mode.OBSERVING and now_ns - execution.stood_ns >= OBSERVATION_NS:
        _take_observation(execution, now_ns, position, heading_rad)


def _update_leg(execution: PlanExecution, now_ns: int, position: FloatArray) -> None:
    leg, item = execution.leg, execution.plan.current
    assert leg is not None
    verdict = leg.assess(now_ns, position, execution.rules)
    if verdict in _CODES:
        _fail_leg(execution, now_ns, leg, _CODES[verdict])
    elif verdict is not LegStatus.ON_THE_WAY:
        missed = ""
        if verdict is LegStatus.NEAR_MISS:
            distance, stall = leg.distance_m(position), seconds(execution.rules.stall_ns)
            missed = f" within the stopped tolerance: {distance:.2f} m away, no progress for {stall:g} s"
        if item is None:
            _come_home(execution, now_ns, missed)
        else:
            _reach(execution, now_ns, item, missed)


def _reach(execution: PlanExecution, now_ns: int, item: PlanItem, missed: str) -> None:
    waypoint = item.waypoint
    if waypoint.index >= 0 and waypoint.index not in execution.reached:
        execution.reached += (waypoint.index,)
    execution.emit(now_ns, EventKind.WAYPOINT_REACHED, f"{waypoint.name} reached{missed}", item)
    if waypoint.hold_ns:
        execution.machine.signal(Signal.START_HOLD)
        execution.stood_ns = now_ns
        text = f"holding at {waypoint.name} for {seconds(waypoint.hold_ns):g} s"
        execution.emit(now_ns, EventKind.HOLD_STARTED, text, item)
    else:
        _do_task(execution, now_ns, item)


def _update_hold(execution: PlanExecution, now_ns: int) -> None:
    item = execution.plan.current
    assert item is not None
    if now_ns - execution.stood_ns >= item.waypoint.hold_ns:
        execution.emit(now_ns, EventKind.HOLD_COMPLETED, f"hold at {item.waypoint.name} completed", item)
        _do_task(execution, now_ns, item)


def _do_task(execution: PlanExecution, now_ns: int, item: PlanItem) -> None:
    if item.waypoint.task == OBSERVE:
        execution.machine.signal(Signal.START_OBSERVATION)
        execution.stood_ns = now_ns
        execution.emit(now_ns, EventKind.OBSERVATION_STARTED, f"observing at {item.waypoint.name}", item)
    else:
        execution.finish_item(now_ns, item)


def _take_observation(execution: PlanExecution, now_ns: int, position: FloatArray, heading_rad: float) -> None:
    item = execution.plan.current
    assert item is not None
    place = f"x {position[0, 0]:.2f} m, y {position[0, 1]:.2f} m, heading {math.degrees(heading_rad):.1f} deg"
    text = f"observation taken at {item.waypoint.name}: {place}"
    execution.emit(now_ns, EventKind.OBSERVATION_TAKEN, text, item)
    execution.finish_item(now_ns, item)


def _come_home(execution: PlanExecution, now_ns: int, missed: str) -> None:
    command_id = execution.home_id
    assert command_id is not None
    execution.emit(now_ns, EventKind.HOME_REACHED, f"home reached{missed}")
    if command_id == BY_RULE:
        execution.stay_home()
    else:
        execution.finish(now_ns, command_id)


def _fail_leg(execution: PlanExecution, now_ns: int, leg: Leg, code: str) -> None:
    """Try the leg again, or do what is to be done when it has failed for good."""
    name, item, tries = leg.waypoint.name, execution.plan.current, execution.rules.retries + 1
    why = f"not reached within {seconds(leg.waypoint.timeout_ns):g} s"
    if code == STUCK:
        why = f"not reached: no progress for {seconds(execution.rules.stall_ns):g} s"
    if leg.tries < tries:
        leg.begin_again(now_ns)
        text = f"{name} {why}: attempt {leg.tries} of {tries}"
        execution.emit(now_ns, EventKind.LEG_RETRIED, text, item, Severity.WARNING)
        return
    kind = EventKind.WAYPOINT_STUCK if code == STUCK else EventKind.WAYPOINT_TIMEOUT
    execution.emit(now_ns, kind, f"{name} {why}", item, Severity.WARNING)
    if item is None:
        execution.fail(now_ns, code)
    else:
        _follow_failure(execution, now_ns, item, code)


def _follow_failure(execution: PlanExecution, now_ns: int, item: PlanItem, code: str) -> None:
    then = item.on_failure or execution.rules.then
    if then == "skip":
        execution.skip_item(now_ns, item, code)
    elif then == "hold":
        execution.suspend(now_ns, Signal.SAFE_HOLD, f"{LEG_FAILED}{item.waypoint.name} {code}")
        execution.suspended = None  # the leg begins afresh, with its whole time
    elif then == "return_home":
        execution.fail_all(now_ns, code)
        execution.go_home(now_ns, BY_RULE, code)
    else:
        execution.fail(now_ns, code)
