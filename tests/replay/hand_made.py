"""A flight written by hand, whose numbers can be worked out on paper.

A robot walks along x at 2 m/s for 3 s of its 5 s, in control steps of 0.5 s. The link takes 1 s each way.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from waypointctl.log.messages import (
    Ack,
    Action,
    Clock,
    Command,
    CommandKind,
    CommandStage,
    Event,
    EventKind,
    Message,
    Mode,
    PlannedWaypoint,
    Reward,
    Severity,
    Stage,
    State,
    Telemetry,
)
from waypointctl.units import NS_PER_S, ns

STEP_NS = NS_PER_S // 2
NEAR = PlannedWaypoint(0, "near", 2.0, 0.0, "box", 0.5, 10 * NS_PER_S, 0)
FAR = PlannedWaypoint(1, "far", 40.0, 30.0, "radius", 1.0, 2 * NS_PER_S, 0)


def event(
    time_s: float, kind: EventKind, text: str, clock: Clock = Clock.ROBOT, waypoint: int = -1, command_id: int = -1
) -> Event:
    return Event(ns(time_s), kind, clock, Severity.INFO, text, waypoint, command_id)


def state(step: int, x_m: float, y_m: float, vx_mps: float) -> State:
    qpos = np.array([x_m, y_m, 0.5, 1.0, 0.0, 0.0, 0.0])
    return State(step * STEP_NS, step, qpos, np.array([vx_mps, 0.0, 0.0, 0.0, 0.0, 0.0]), np.zeros(6))


def step(index: int, source: str, x_m: float, vx_mps: float, progress: float) -> Iterator[Message]:
    """One control step that begins at x_m."""
    yield state(index, x_m, 0.0, vx_mps)
    yield Action(index * STEP_NS, index, source, np.zeros(8), np.zeros(8))
    terms = (("progress", progress), ("energy", -0.25))
    yield Reward((index + 1) * STEP_NS, index, terms, progress - 0.25)


def ack(stage: Stage, issued_s: float, reason: str = "") -> Ack:
    return Ack(1, stage, reason, ns(issued_s), ns(issued_s + 1.0))


def stage(
    time_s: float, which: Stage, clock: Clock = Clock.ROBOT, reason: str = "", attempt: int = 1, command_id: int = 1
) -> CommandStage:
    return CommandStage(ns(time_s), command_id, which, reason, clock, attempt)


def frame(number: int, issued_s: float, x_m: float, reached: tuple[int, ...], target: int = 0) -> Telemetry:
    return Telemetry(
        number, Mode.NAVIGATING, x_m, 0.0, 0.5, 0.0, 2.0, target, reached, ns(issued_s), ns(issued_s + 1.0)
    )


def flight() -> Iterator[Message]:
    """Command at 0, arrived at 1.0, `near` reached at 2.0 and known at 3.0, `far` given up at 4.0, told at 5.0."""
    yield event(0, EventKind.MISSION_STARTED, "mission hand started", Clock.OPERATOR)
    yield event(0, EventKind.COMMAND_SENT, "command 1 sent: upload_plan near, far", Clock.OPERATOR, command_id=1)
    yield stage(0, Stage.QUEUED, Clock.OPERATOR)
    yield stage(0, Stage.SENT, Clock.OPERATOR)
    yield from step(0, "stance", 0.0, 0.0, 0.0)
    yield frame(0, 0.0, 0.0, (), -1)
    yield from step(1, "stance", 0.0, 0.0, 0.0)
    yield Command(1, CommandKind.UPLOAD_PLAN, (NEAR, FAR), "abort", 0, ns(1.0))
    yield stage(1, Stage.RECEIVED)
    yield event(1, EventKind.COMMAND_RECEIVED, "command 1 received", command_id=1)
    yield stage(1, Stage.ACCEPTED)
    yield stage(1, Stage.STARTED)
    yield event(1, EventKind.LEG_STARTED, "driving to near", waypoint=0, command_id=1)
    yield from step(2, "policy", 0.0, 2.0, 2.0)
    yield from step(3, "policy", 1.0, 2.0, 2.0)
    for told in (Stage.RECEIVED, Stage.ACCEPTED, Stage.STARTED):
        yield ack(told, 1.0)
    yield event(2, EventKind.WAYPOINT_REACHED, "near reached", waypoint=0, command_id=1)
    yield event(2, EventKind.LEG_STARTED, "driving to far", waypoint=1, command_id=1)
    yield from step(4, "policy", 2.0, 2.0, 1.0)
    yield from step(5, "policy", 3.0, 2.0, 1.0)
    yield frame(1, 2.0, 2.0, (0,), 1)
    yield from step(6, "policy", 4.0, 2.0, 1.0)
    yield from step(7, "policy", 5.0, 2.0, 1.0)
    yield event(4, EventKind.WAYPOINT_TIMEOUT, "far not reached within 2 s", waypoint=1, command_id=1)
    yield event(4, EventKind.PLAN_FAILED, "plan aborted at far", waypoint=1, command_id=1)
    yield stage(4, Stage.FAILED, reason="timeout")
    yield from step(8, "stance", 6.0, 0.0, 0.0)
    yield from step(9, "stance", 6.3, 0.0, 0.0)
    yield ack(Stage.FAILED, 4.0, "timeout")
    yield state(10, 6.3, 0.4, 0.0)
    yield event(5, EventKind.MISSION_ENDED, "failure: timeout: 1 of 2 waypoints reached", Clock.OPERATOR)
