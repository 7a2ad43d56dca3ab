"""Autonomy `joint`: the policy runs on the ground and sends every action.

The robot reports its body's state at each control step. Each state that arrives is answered with an action computed
from it, which is one round trip old when the motors get it. Without delay that is the flight of a policy on board,
bit for bit; with delay the robot is balanced over the link.

A picture is taken on board. For one, the operator sends the waypoint with its hold and its task, sends no actions until
their end is reported, and continues from there. A hold at the last waypoint is handled in the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.executive.rules import AT_HOME, FALL, TIMEOUT
from waypointctl.flight.link.frames import BodyFrame
from waypointctl.flight.operator.operator import Operator, ended_by_robot, leg_failed
from waypointctl.flight.operator.requests import CommandRequest
from waypointctl.flight.policy_fit import chosen_action
from waypointctl.log.messages import (
    TELEOPERATION,
    Ack,
    CommandKind,
    Event,
    EventKind,
    GroundControl,
    Mode,
    Severity,
    Stage,
    Telemetry,
)
from waypointctl.mission.fields import Acceptance
from waypointctl.mission.mission import Mission
from waypointctl.policy.protocol import Policy
from waypointctl.robots.robot import Robot
from waypointctl.sim.actions import clip_actions
from waypointctl.task.observation import layout
from waypointctl.task.plugins import Plugin
from waypointctl.task.progress import reached
from waypointctl.task.view import SimulationView, body_of

FloatArray = NDArray[np.float64]


class JointOperator(Operator):
    """Computes every action on the ground."""

    def __init__(
        self,
        mission: Mission,
        policy: Policy,
        robot: Robot,
        noise: FloatArray,
        plugins: Sequence[Plugin],
        announce: Callable[[Event], None],
    ) -> None:
        """Start a mission. noise: (4,) for layouts that have some; `announce` takes the operator's events."""
        super().__init__(mission, announce)
        self._policy = policy
        self._robot = robot
        self._layout = layout(policy.observation_layout, robot, plugins)
        self._action: FloatArray = np.zeros((1, robot.num_actions))  # the latest, as clipped
        self._noise = noise[np.newaxis]
        self._skips = mission.failure_rule.then == "skip"
        self._reached: list[int] = []
        self._leg = 0
        self._since_ns = 0  # on the robot's clock, from its frames
        self._rests_until_ns = -1  # on the robot's clock
        self._at_task = False  # hold and observe were commanded, and their end is not known
        self._goals = self._goals_of(0)

    @property
    def reached(self) -> tuple[int, ...]:
        """The waypoints that it has seen the robot reach."""
        return tuple(self._reached)

    @property
    def acts_on_states(self) -> bool:
        """Whether every state of the robot that arrives may make it send something."""
        return not (self.finished or self.suspended or self._at_task)

    def begin(self) -> list[CommandRequest]:
        """Send nothing: the first state is answered."""
        return []

    def on_message(self, now_ns: int, message: Ack | Telemetry) -> list[CommandRequest]:
        """Take what has arrived; a fall ends it."""
        requests = super().on_message(now_ns, message)
        if isinstance(message, Telemetry) and message.mode is Mode.FALLEN and not self.finished:
            return self._finish(FALL)
        return requests

    def on_state(self, now_ns: int, frame: BodyFrame) -> tuple[GroundControl | None, list[CommandRequest]]:
        """Take a state that has arrived; return the action that answers it, and what else to send."""
        if self.finished or self.suspended or self._is_stopped(frame):
            return None, []
        requests = self._judge(now_ns, frame)
        if self.finished or self._is_stopped(frame):
            return None, requests
        qpos, qvel = frame.qpos[np.newaxis], frame.qvel[np.newaxis]
        view = SimulationView(
            robot=self._robot,
            body=body_of(qpos, qvel),
            qpos=qpos,
            goals=self._goals,
            noise=self._noise,
            action=self._action,
            steps=np.array([frame.issued_ns // self._robot.control_period_ns]),
        )
        observation = self._layout.observe(view)
        action = chosen_action(self._policy, observation, self._robot.num_actions)
        self._action = clip_actions(action)
        return GroundControl(now_ns, frame.step, frame.issued_ns, observation[0], action[0]), requests

    def state(self) -> dict[str, object]:
        """Return what it will do next depends on, as plain data."""
        own = {"leg": self._leg, "since_ns": self._since_ns, "rests_until_ns": self._rests_until_ns}
        return super().state() | own | ({"at_task": True} if self._at_task else {})

    def _is_stopped(self, frame: BodyFrame) -> bool:
        """Return whether the robot is to be left alone: it holds, or does what is to be done at a waypoint."""
        return self._at_task or frame.issued_ns < self._rests_until_ns

    def _judge(self, now_ns: int, frame: BodyFrame) -> list[CommandRequest]:
        """Check whether the leg is over. It is assessed after its first control period, as on board."""
        waypoint = self._plan[self._leg]
        if frame.issued_ns <= self._since_ns:
            return []
        acceptance = Acceptance.of(waypoint.acceptance, waypoint.tolerance_m)
        if reached(acceptance, frame.qpos[np.newaxis], self._goals[:, 0])[0]:
            self._reached.append(waypoint.index)
            self._announce_decision(
                now_ns, EventKind.WAYPOINT_REACHED, waypoint, "reached, as seen from the ground", Severity.INFO
            )
            if waypoint.task or (waypoint.hold_ns and self._is_last):
                self._at_task = True
                return [CommandRequest(CommandKind.GO_TO, (waypoint,), "abort")]
            return self._next_leg(frame.issued_ns, waypoint.hold_ns)
        if frame.issued_ns - self._since_ns < waypoint.timeout_ns:
            return []
        self._announce_decision(now_ns, EventKind.WAYPOINT_TIMEOUT, waypoint, "not reached in time")
        if self._skips:
            self._announce_decision(now_ns, EventKind.WAYPOINT_SKIPPED, waypoint, f"skipped: {TIMEOUT}")
            return self._next_leg(frame.issued_ns, 0)
        return [*self._stop(), *self._finish(self._taken_by or TIMEOUT)]

    def _next_leg(self, since_ns: int, hold_ns: int) -> list[CommandRequest]:
        """Turn to the next waypoint, after a hold; since_ns is on the robot's clock."""
        requests = self._stop() if hold_ns or self._is_last else []
        if self._is_last:
            return requests + self._finish()
        self._leg += 1
        self._goals = self._goals_of(self._leg)
        self._rests_until_ns = since_ns + hold_ns if hold_ns else -1
        self._since_ns = max(since_ns, self._rests_until_ns)
        return requests

    def _stop(self) -> list[CommandRequest]:
        """Return the commands that stop the robot: a way home, which may have begun meanwhile, is not interrupted."""
        frame = self.reported.telemetry
        if frame is not None and frame.mode is Mode.RETURNING:
            return []
        return [CommandRequest(CommandKind.HOLD, target_id=TELEOPERATION)]

    @property
    def _taken_by(self) -> str:
        """The rule on board that ended teleoperation, from the newest frame; empty for none."""
        frame = self.reported.telemetry
        taken = frame is not None and frame.mode in (Mode.RETURNING, Mode.SAFE)
        return frame.cause.removeprefix(AT_HOME) if frame is not None and taken else ""

    @property
    def _is_last(self) -> bool:
        return self._leg + 1 == len(self._plan)

    def _goals_of(self, leg: int) -> FloatArray:
        """Return this leg's waypoint and the next, (1, 2, 2) [m]."""
        two = self._plan[leg], self._plan[min(leg + 1, len(self._plan) - 1)]
        return np.array([[[waypoint.x_m, waypoint.y_m] for waypoint in two]])

    def _on_final(self, now_ns: int, ack: Ack) -> list[CommandRequest]:
        if self.finished:
            return []
        if ack.reason == FALL:
            return self._finish(FALL)
        if not self._at_task or ack.command_id != self._newest.get(CommandKind.GO_TO):
            return []
        self._at_task = False
        if ack.stage is Stage.COMPLETED or (self._skips and leg_failed(ack)):
            return self._next_leg(ack.issued_ns, 0)
        return self._finish(ended_by_robot(ack, self._kinds))
