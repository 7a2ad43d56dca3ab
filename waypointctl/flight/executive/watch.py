"""What the robot watches while it does something else: the link to the ground, and the fence."""

from __future__ import annotations

from dataclasses import dataclass

from waypointctl.flight.executive.machine import BUSY, ON_FOOT, TRANSITIONS, Signal
from waypointctl.flight.executive.rules import AT_HOME, GEOFENCE, LINK_LOST
from waypointctl.flight.executive.walk import BY_RULE, Walk
from waypointctl.log.messages import EventKind, Mode, Severity
from waypointctl.units import seconds


@dataclass(slots=True)
class LinkWatch:
    """Whether the ground is still heard.

    What follows when it is heard again: a robot that stands because of the loss goes on with what it was kept from;
    one that went home because of it is idle there, or walks on until it is, for its plan has been given up.

    Attributes:
        heard_ns: when anything last arrived; None before the first, when there is no link to lose yet.
        lost: whether that is too long ago.
    """

    heard_ns: int | None = None
    lost: bool = False

    def hear(self, walk: Walk, now_ns: int) -> None:
        """Take note that something has arrived."""
        self.heard_ns = now_ns
        if not self.lost:
            return
        self.lost = False
        walk.tell(now_ns, EventKind.LINK_RESTORED, "the ground is heard again")
        if self.holds(walk):
            walk.go_on(now_ns)
        elif walk.mode is Mode.SAFE and walk.cause in (LINK_LOST, AT_HOME + LINK_LOST):
            walk.rest()

    def holds(self, walk: Walk) -> bool:
        """Tell whether the robot stands because of the loss, and has something to go on with."""
        return walk.mode is Mode.SAFE and walk.cause == LINK_LOST and walk.can_go_on

    def look(self, walk: Walk, now_ns: int) -> None:
        """Do what the rules say once nothing has arrived for too long."""
        deadline_ns = self.deadline_ns(walk)
        if deadline_ns is None or now_ns <= deadline_ns:
            return
        self.lost = True
        does = _done_on_loss(walk)
        text = f"nothing heard for {seconds(walk.rules.link_loss_ns):g} s{': ' * bool(does)}{does}"
        walk.tell(now_ns, EventKind.LINK_LOST, text, severity=Severity.WARNING)
        if does == "hold":
            walk.suspend(now_ns, Signal.SECURE, LINK_LOST)
        elif does == "return_home":
            walk.fail_all(now_ns, LINK_LOST)
            walk.go_home(now_ns, BY_RULE, LINK_LOST)

    def deadline_ns(self, walk: Walk) -> int | None:
        """Return until when something has to arrive; None if nothing has to."""
        if self.lost or self.heard_ns is None or not walk.rules.link_loss_ns:
            return None
        return self.heard_ns + walk.rules.link_loss_ns

    def keeps_still(self, walk: Walk) -> bool:
        """Tell whether commands that were kept for later have to wait for the link."""
        return self.lost and walk.rules.on_link_loss != "finish"


def _done_on_loss(walk: Walk) -> str:
    """Return which rule changes what the robot does now that the link is lost; empty where it goes on as it is."""
    rule = walk.rules.on_link_loss
    if rule == "hold":
        return rule if (walk.mode, Signal.SECURE) in TRANSITIONS else ""
    if rule == "return_home":
        return rule if walk.home_id is None else ""
    return rule if walk.mode in BUSY else ""


@dataclass(slots=True)
class FenceWatch:
    """Whether the robot has walked out of its fence. One that walks back in from outside is let alone.

    Attributes:
        outside: whether it was out when it last walked.
    """

    outside: bool = False

    def look(self, walk: Walk, now_ns: int, x_m: float, y_m: float) -> None:
        """Do what the rules say when a robot that moves crosses the fence.

        One that the ground steers has no plan to abort: it stands until a command, not an action, says otherwise.
        """
        steered = walk.mode is Mode.TELEOPERATED
        if walk.mode not in ON_FOOT and not steered:
            return
        breach = walk.rules.fence.breach(x_m, y_m)
        was_outside, self.outside = self.outside, bool(breach)
        if not breach or was_outside:
            return
        text = f"the robot at ({x_m:.2f}, {y_m:.2f}) {breach}"
        walk.tell(now_ns, EventKind.GEOFENCE_BREACHED, text, walk.plan.current, Severity.ERROR)
        if walk.rules.on_breach == "hold" or (walk.rules.on_breach == "abort" and steered):
            walk.suspend(now_ns, Signal.SECURE, f"{GEOFENCE}: the robot {breach}")
        elif walk.rules.on_breach == "abort":
            walk.give_up(now_ns, GEOFENCE)
        elif walk.home_id is None:
            walk.fail_all(now_ns, GEOFENCE)
            walk.go_home(now_ns, BY_RULE, GEOFENCE)
