"""Monitors on board: the link to the ground, and the geofence."""

from __future__ import annotations

from dataclasses import dataclass

from waypointctl.flight.executive.plan_execution import BY_RULE, PlanExecution
from waypointctl.flight.executive.rules import AT_HOME, GEOFENCE, LINK_LOST
from waypointctl.flight.executive.state_machine import BUSY, POLICY_MODES, TRANSITIONS, Signal
from waypointctl.log.messages import EventKind, Mode, Severity
from waypointctl.units import seconds


@dataclass(slots=True)
class LinkMonitor:
    """Detects the loss of the link.

    When the link is restored, a robot that holds because of the loss resumes what was interrupted. One that returned
    home because of it is idle there, or continues home, because its plan has been aborted.

    Attributes:
        last_ns: when a message last arrived; None before the first.
        lost: whether that is too long ago.
    """

    last_ns: int | None = None
    lost: bool = False

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
    """Detects that the robot leaves its geofence. Coming back in from outside has no effect.

    Attributes:
        outside: whether it was outside when it last moved.
    """

    outside: bool = False

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
