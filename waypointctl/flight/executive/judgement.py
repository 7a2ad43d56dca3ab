"""What the robot's place and time make of the walk: waypoints reached, held and observed, and legs that fail."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.executive.leg import Leg, Verdict
from waypointctl.flight.executive.machine import ON_FOOT, Signal
from waypointctl.flight.executive.plan import Item
from waypointctl.flight.executive.rules import LEG_FAILED, STUCK, TIMEOUT
from waypointctl.flight.executive.walk import BY_RULE, Walk
from waypointctl.log.messages import EventKind, Mode, Severity
from waypointctl.units import NS_PER_S, seconds

FloatArray = NDArray[np.float64]

OBSERVE: Final = "observe"
OBSERVATION_NS: Final = NS_PER_S  # how long the robot stands for a picture

_CODES: Final = {Verdict.OUT_OF_TIME: TIMEOUT, Verdict.STUCK: STUCK}


def judge(walk: Walk, now_ns: int, position: FloatArray, heading_rad: float) -> None:
    """Look at where the robot is, position (1, >= 2) [m], and take what follows from it."""
    if walk.mode in ON_FOOT:
        _judge_leg(walk, now_ns, position)
    elif walk.mode is Mode.HOLDING:
        _judge_hold(walk, now_ns)
    elif walk.mode is Mode.OBSERVING and now_ns - walk.stood_ns >= OBSERVATION_NS:
        _take_observation(walk, now_ns, position, heading_rad)


def _judge_leg(walk: Walk, now_ns: int, position: FloatArray) -> None:
    leg, item = walk.leg, walk.plan.current
    assert leg is not None
    verdict = leg.judge(now_ns, position, walk.rules)
    if verdict in _CODES:
        _fail_leg(walk, now_ns, leg, _CODES[verdict])
    elif verdict is not Verdict.ON_THE_WAY:
        missed = ""
        if verdict is Verdict.NEAR_MISS:
            distance, stall = leg.distance_m(position), seconds(walk.rules.stall_ns)
            missed = f" within the slip: {distance:.2f} m away and no closer for {stall:g} s"
        if item is None:
            _come_home(walk, now_ns, missed)
        else:
            _reach(walk, now_ns, item, missed)


def _reach(walk: Walk, now_ns: int, item: Item, missed: str) -> None:
    waypoint = item.waypoint
    if waypoint.index >= 0 and waypoint.index not in walk.reached:
        walk.reached += (waypoint.index,)
    walk.tell(now_ns, EventKind.WAYPOINT_REACHED, f"{waypoint.name} reached{missed}", item)
    if waypoint.hold_ns:
        walk.machine.signal(Signal.HOLD_BEGUN)
        walk.stood_ns = now_ns
        text = f"holding at {waypoint.name} for {seconds(waypoint.hold_ns):g} s"
        walk.tell(now_ns, EventKind.HOLD_STARTED, text, item)
    else:
        _do_task(walk, now_ns, item)


def _judge_hold(walk: Walk, now_ns: int) -> None:
    item = walk.plan.current
    assert item is not None
    if now_ns - walk.stood_ns >= item.waypoint.hold_ns:
        walk.tell(now_ns, EventKind.HOLD_COMPLETED, f"hold at {item.waypoint.name} completed", item)
        _do_task(walk, now_ns, item)


def _do_task(walk: Walk, now_ns: int, item: Item) -> None:
    if item.waypoint.task == OBSERVE:
        walk.machine.signal(Signal.OBSERVATION_BEGUN)
        walk.stood_ns = now_ns
        walk.tell(now_ns, EventKind.OBSERVATION_STARTED, f"observing at {item.waypoint.name}", item)
    else:
        walk.conclude(now_ns, item)


def _take_observation(walk: Walk, now_ns: int, position: FloatArray, heading_rad: float) -> None:
    item = walk.plan.current
    assert item is not None
    place = f"x {position[0, 0]:.2f} m, y {position[0, 1]:.2f} m, heading {math.degrees(heading_rad):.1f} deg"
    text = f"observation taken at {item.waypoint.name}: {place}"
    walk.tell(now_ns, EventKind.OBSERVATION_TAKEN, text, item)
    walk.conclude(now_ns, item)


def _come_home(walk: Walk, now_ns: int, missed: str) -> None:
    command_id = walk.home_id
    assert command_id is not None
    walk.tell(now_ns, EventKind.HOME_REACHED, f"home reached{missed}")
    if command_id == BY_RULE:
        walk.stay_home()
    else:
        walk.finish(now_ns, command_id)


def _fail_leg(walk: Walk, now_ns: int, leg: Leg, code: str) -> None:
    """Try the leg again, or do what is to be done when it has failed for good."""
    name, item, tries = leg.waypoint.name, walk.plan.current, walk.rules.retries + 1
    why = f"not reached within {seconds(leg.waypoint.timeout_ns):g} s"
    if code == STUCK:
        why = f"not reached, and no closer for {seconds(walk.rules.stall_ns):g} s"
    if leg.tries < tries:
        leg.begin_again(now_ns)
        text = f"{name} {why}: try {leg.tries} of {tries}"
        walk.tell(now_ns, EventKind.LEG_RETRIED, text, item, Severity.WARNING)
        return
    kind = EventKind.WAYPOINT_STUCK if code == STUCK else EventKind.WAYPOINT_TIMEOUT
    walk.tell(now_ns, kind, f"{name} {why}", item, Severity.WARNING)
    if item is None:
        walk.give_up(now_ns, code)
    else:
        _follow_failure(walk, now_ns, item, code)


def _follow_failure(walk: Walk, now_ns: int, item: Item, code: str) -> None:
    then = item.on_failure or walk.rules.then
    if then == "skip":
        walk.pass_over(now_ns, item, code)
    elif then == "hold":
        walk.suspend(now_ns, Signal.SECURE, f"{LEG_FAILED}{item.waypoint.name} {code}")
        walk.suspended = None  # the leg begins afresh, with its whole time
    elif then == "return_home":
        walk.fail_all(now_ns, code)
        walk.go_home(now_ns, BY_RULE, code)
    else:
        walk.give_up(now_ns, code)
