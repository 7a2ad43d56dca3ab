"""A flight that nobody flew: a robot of three bodies, and messages with all the awkward values floats can have.

As a program it writes that flight: `python -m tests.log.fake_flight OUT.mcap [--steps N] [--die-after N]`.
"""

from __future__ import annotations

import argparse
import os
import signal
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np

from waypointctl.log.header import Attachment, LogHeader
from waypointctl.log.messages import (
    Ack,
    Action,
    Checkpoint,
    Clock,
    Command,
    CommandKind,
    Event,
    EventKind,
    FloatArray,
    Message,
    Mode,
    Observation,
    PlannedWaypoint,
    Reward,
    Severity,
    Stage,
    State,
    Telemetry,
)
from waypointctl.log.writer import LogWriter
from waypointctl.sim.geometry import WORLD, Geom
from waypointctl.units import NS_PER_S

STEP_NS = NS_PER_S // 50
UP_NS = 1_280_000_000
DOWN_NS = 1_290_000_000
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
WAYPOINTS = (
    PlannedWaypoint(0, "north", 3.0, 4.0, "box", 0.5, 10 * NS_PER_S, 0),
    PlannedWaypoint(1, "east", 6.0, 4.0, "radius", 0.4, 20 * NS_PER_S, NS_PER_S),
)


class FakeKinematics:
    """A torso with two legs that stand straight down from it, whatever the joints say."""

    body_names = ("torso", "left", "right")
    joint_names = ("left_hip", "right_hip")
    geoms = (
        Geom(WORLD, "plane", (0.0, 0.0, 0.0), UPRIGHT, (0.0, 0.0, 1.0), (0.5, 0.5, 0.5, 1.0)),
        Geom("torso", "sphere", (0.0, 0.0, 0.1), UPRIGHT, (0.25, 0.0, 0.0), (0.8, 0.6, 0.4, 1.0)),
        # A quarter turn about y lays the capsule's axis along x.
        Geom(
            "left", "capsule", (0.1, 0.0, 0.0), (0.5**0.5, 0.0, 0.5**0.5, 0.0), (0.08, 0.3, 0.0), (1.0, 0.0, 0.0, 1.0)
        ),
        Geom("right", "box", (0.0, 0.0, 0.0), UPRIGHT, (0.1, 0.2, 0.3), (0.0, 1.0, 0.0, 1.0)),
    )

    def poses(self, qpos: FloatArray) -> tuple[FloatArray, FloatArray]:
        offsets = np.array([[0.0, 0.0, 0.0], [0.0, 0.2, -0.3], [0.0, -0.2, -0.3]])
        return qpos[:3] + offsets, np.tile(qpos[3:7], (3, 1))


def header(**metadata: str) -> LogHeader:
    return LogHeader(
        robot="fake",
        kinematics=FakeKinematics(),
        waypoints=WAYPOINTS,
        attachments=(
            Attachment("mission.yaml", "application/yaml", b"name: fake\n"),
            Attachment("model.mjb", "application/octet-stream", bytes(range(256)) * 40),
        ),
        metadata={"seed": "7", "epoch": "mission start", **metadata},
    )


def flight(steps: int = 200) -> Iterator[Message]:
    """Yield a flight of `steps` control steps in the order in which a flight loop would."""
    rng = np.random.default_rng(7)
    yield Event(0, EventKind.MISSION_STARTED, Clock.OPERATOR, Severity.INFO, "the mission begins")
    for step in range(steps):
        now = step * STEP_NS
        yield from _link(step, now)
        qpos = np.concatenate([[0.02 * step, 0.01 * step, 0.5], UPRIGHT, rng.normal(size=2)])
        yield State(now, step, qpos, rng.normal(size=8), rng.normal(size=8))
        yield Observation(now, step, rng.normal(size=12))
        commanded = rng.normal(size=2)
        yield Action(now, step, "policy", commanded, np.clip(commanded, -1.0, 1.0))
        terms = (("progress", float(rng.normal())), ("energy", -0.0), ("alive", 1.0))
        yield Reward(now + STEP_NS, step, terms, sum(value for _, value in terms))
    yield Event(steps * STEP_NS, EventKind.MISSION_ENDED, Clock.OPERATOR, Severity.INFO, "the mission ends")


def _link(step: int, now: int) -> Iterator[Message]:
    if now == UP_NS:
        yield Command(1, CommandKind.UPLOAD_PLAN, WAYPOINTS, "abort", 0, now)
        yield Event(now, EventKind.COMMAND_RECEIVED, Clock.ROBOT, Severity.INFO, "plan received", command_id=1)
    if now == UP_NS + STEP_NS:
        yield Event(now, EventKind.LEG_STARTED, Clock.ROBOT, Severity.INFO, "to north", waypoint=0)
    if now == UP_NS + 50 * STEP_NS:
        yield Event(now, EventKind.WAYPOINT_REACHED, Clock.ROBOT, Severity.INFO, "north reached", waypoint=0)
    if now == UP_NS + 60 * STEP_NS:
        yield Event(now, EventKind.WAYPOINT_TIMEOUT, Clock.ROBOT, Severity.WARNING, "east missed", waypoint=1)
    if step % 25 == 0 and now >= DOWN_NS:
        yield Telemetry(step // 25, Mode.NAVIGATING, 0.1 * step, -0.0, 0.5, 0.1, 1.5, 0, (0, 1), now - DOWN_NS, now)
        yield Ack(1, Stage.STARTED, "", now - DOWN_NS, now)
    if step % 50 == 0:
        yield Checkpoint(now, step, np.full(30, float(step)), '{"mode": "navigating"}', "{}")


def bits(message: object) -> object:
    """Return what two messages share if and only if they are equal to the last bit."""
    if is_dataclass(message):
        return type(message), tuple(bits(getattr(message, field.name)) for field in fields(message))
    if isinstance(message, np.ndarray):
        return message.dtype, message.shape, message.tobytes()
    if isinstance(message, float):
        return np.float64(message).tobytes()
    if isinstance(message, tuple):
        return tuple(bits(item) for item in message)
    return type(message), message


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("out", type=Path)
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("--die-after", type=int, help="be killed after this many messages")
    options = parser.parse_args()
    with LogWriter(options.out, header()) as sink:
        for count, message in enumerate(flight(options.steps)):
            if count == options.die_after:
                os.kill(os.getpid(), signal.SIGKILL)
            sink(message)


if __name__ == "__main__":
    main()
