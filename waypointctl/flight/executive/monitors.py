"""What the executive looks at in every control period: the leg under way, the link to the ground, and the geofence."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.executive.plan import Leg, LegStatus, PlanItem
from waypointctl.flight.executive.plan_execution import BY_RULE, PlanExecution
from waypointctl.flight.executive.rules import AT_HOME, GEOFENCE, LEG_FAILED, LINK_LOST, OBSERVATION_NS, STUCK, TIMEOUT
from waypointctl.flight.executive.state_machine import BUSY, POLICY_MODES, TRANSITIONS, Signal
from waypointctl.log.messages import EventKind, Mode, Severity
from waypointctl.units import seconds

FloatArray = NDArray[np.float64]

OBSERVE: Final = "observe"

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


@dataclass(slots=True)
class LinkMonitor:
    """Detects the loss of the link.

    When the link is restored, a robot that holds because of the loss resumes what was interrupted. One that returned
    home because of it is idle there, or continues home, because its plan has been aborted.
    """

    last_ns: int | None = None  # when a message last arrived; None before the first
    lost: bool = False  # whether that is too long ago

    def on_contact(self, execution: PlanExecution, now_ns: int) -> None:
        """Record that a message has arrived."""
        self.last_ns = now_ns
        if not self.lost:
            return
        self.lost = False
        execution.emit(now_ns, EventKind.LINK_RESTORED, "link restored: a message has arrived")
        if self.resumes_on_contact(execution):
            execution.resume(now_ns)
        elif execution.mode is Mode.SAFE and execution.cause in (LINK_LOST, AT_HOME + LINK_LOST):
            execution.stand_idle()

    def resumes_on_contact(self, execution: PlanExecution) -> bool:
        """Return whether the robot holds because of the loss, and has something to resume."""
        return execution.mode is Mode.SAFE and execution.cause == LINK_LOST and execution.can_go_on

    def check(self, execution: PlanExecution, now_ns: int) -> None:
        """Apply the rule for link loss once nothing has arrived for too long."""
        deadline_ns = self.deadline_ns(execution)
        if deadline_ns is None or now_ns <= deadline_ns:
            return
        self.lost = True
        does = _done_on_loss(execution)
        text = f"link lost after {seconds(execution.rules.link_loss_ns):g} s without a message{': ' * bool(does)}{does}"
        execution.emit(now_ns, EventKind.LINK_LOST, text, severity=Severity.WARNING)
        if does == "hold":
            execution.suspend(now_ns, Signal.SAFE_HOLD, LINK_LOST)
        elif does == "return_home":
            execution.fail_all(now_ns, LINK_LOST)
            execution.go_home(now_ns, BY_RULE, LINK_LOST)

    def deadline_ns(self, execution: PlanExecution) -> int | None:
        """Return until when something has to arrive; None if nothing has to."""
        if self.lost or self.last_ns is None or not execution.rules.link_loss_ns:
            return None
        return self.last_ns + execution.rules.link_loss_ns

    def blocks_commands(self, execution: PlanExecution) -> bool:
        """Return whether commands that were kept for later have to wait for the link."""
        return self.lost and execution.rules.on_link_loss != "finish"


def _done_on_loss(execution: PlanExecution) -> str:
    """Return the rule that changes what the robot does when the link is lost; empty where nothing changes."""
    rule = execution.rules.on_link_loss
    if rule == "hold":
        return rule if (execution.mode, Signal.SAFE_HOLD) in TRANSITIONS else ""
    if rule == "return_home":
        return rule if execution.home_id is None else ""
    return rule if execution.mode in BUSY else ""


@dataclass(slots=True)
class FenceMonitor:
    """Detects that the robot leaves its geofence. Coming back in from outside has no effect."""

    outside: bool = False  # whether it was outside when it last moved

    def check(self, execution: PlanExecution, now_ns: int, x_m: float, y_m: float) -> None:
        """Apply the rule for a breach when a moving robot crosses the fence.

        A teleoperated robot has no plan to abort: it holds until a command, not an action, arrives.
        """
        teleoperated = execution.mode is Mode.TELEOPERATED
        if execution.mode not in POLICY_MODES and not teleoperated:
            return
        breach = execution.rules.fence.breach(x_m, y_m)
        was_outside, self.outside = self.outside, bool(breach)
        if not breach or was_outside:
            return
        text = f"the robot at ({x_m:.2f}, {y_m:.2f}) {breach}"
        execution.emit(now_ns, EventKind.GEOFENCE_BREACHED, text, execution.plan.current, Severity.ERROR)
        if execution.rules.on_breach == "hold" or (execution.rules.on_breach == "abort" and teleoperated):
            execution.suspend(now_ns, Signal.SAFE_HOLD, f"{GEOFENCE}: the robot {breach}")
        elif execution.rules.on_breach == "abort":
            execution.fail(now_ns, GEOFENCE)
        elif execution.home_id is None:
            execution.fail_all(now_ns, GEOFENCE)
            execution.go_home(now_ns, BY_RULE, GEOFENCE)
