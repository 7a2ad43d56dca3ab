"""The robot in flight: its physics, its executive, its policy, and what it reports."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.log.messages import (
    FINAL_STAGES,
    Ack,
    Action,
    Checkpoint,
    Command,
    CommandStage,
    Mode,
    Observation,
    Reward,
    Stage,
    State,
    Telemetry,
)
from waypointctl.ops.executive.executive import Executive
from waypointctl.ops.executive.rules import Rules
from waypointctl.ops.link.logged import LoggedDirection
from waypointctl.ops.pay import reward_weights
from waypointctl.ops.sink import Sink
from waypointctl.policy.protocol import Policy
from waypointctl.sim.robots import Robot
from waypointctl.sim.single import SingleRobot
from waypointctl.sim.stance import stance_action
from waypointctl.task.batched import clip_actions
from waypointctl.task.body import Body, body_of, fallen
from waypointctl.task.observation import NOISE_SIZE, Goals, layout
from waypointctl.task.reward import TERMS, JointLimits, progress_speed, reward_terms

FloatArray = NDArray[np.float64]

_STILL: Final = np.zeros(1)
_NOTHING: Final = np.zeros((1, len(TERMS)))

# The end of a command is told after a frame of telemetry: the operator hears of the waypoints before the verdict.
_TOLD_WITH_A_FRAME: Final = FINAL_STAGES - {Stage.REJECTED, Stage.SKIPPED}


class Vehicle:
    """One robot that obeys commands. It is told the time and never looks ahead of it."""

    def __init__(
        self,
        robot: Robot,
        policy: Policy,
        sink: Sink,
        downlink: LoggedDirection[Ack | Telemetry],
        telemetry_period_ns: int,
        rules: Rules,
    ) -> None:
        """Make a robot that reports through `downlink` and logs its truth into `sink`; `place` it before flight."""
        self.robot = robot
        self.plant = SingleRobot(robot)
        self.executive = Executive(self._report, sink, remind=self._acknowledge, rules=rules)
        self.step = 0
        self._policy = policy
        self._layout = layout(policy.observation_layout)
        self._weights = reward_weights(policy)
        self._limits = JointLimits.of_range(robot.joint_low, robot.joint_high)
        self._sink = sink
        self._downlink = downlink
        self._telemetry_period_ns = telemetry_period_ns
        self._next_telemetry_ns = 0
        self._frame = 0
        self._body: Body = body_of(self.plant.qpos, self.plant.qvel)
        self._fell = False
        self._closed = False
        self._noise: FloatArray = np.zeros((1, NOISE_SIZE))

    def place(self, qpos: FloatArray, qvel: FloatArray, noise: FloatArray) -> None:
        """Put the robot where the mission begins: qpos (nq,), qvel (nv,); noise (4,) is for layouts that have some."""
        self._noise = noise[np.newaxis]
        self.plant.place(qpos[np.newaxis], qvel[np.newaxis])
        self._look()

    def obey(self, now_ns: int, command: Command) -> None:
        """Take a command that has arrived."""
        self.executive.obey(now_ns, command)
        self._downlink_frame(now_ns)

    def sense(self, now_ns: int) -> None:
        """Let the executive look at the world; report at the telemetry rate and whenever its mode changes."""
        before = (self.executive.mode, self.executive.leg, len(self.executive.reached))
        self.executive.sense(now_ns, self._body.position, self._fell, float(self._body.yaw[0]))
        changed = before != (self.executive.mode, self.executive.leg, len(self.executive.reached))
        due = now_ns >= self._next_telemetry_ns
        while now_ns >= self._next_telemetry_ns:
            self._next_telemetry_ns += self._telemetry_period_ns
        if changed or due:
            self._downlink_frame(now_ns)

    def act(self, now_ns: int) -> None:
        """Log what is, choose an action, apply it for one control period, log what it was paid."""
        self.log_state(now_ns)
        source, commanded = self._choose(now_ns)
        applied = clip_actions(commanded)
        self._sink(Action(now_ns, self.step, source, commanded[0], applied[0]))
        before = self.plant.qpos[:, :2].copy()
        self.plant.step(applied)
        self._look()
        self._log_reward(now_ns + self.robot.control_period_ns, before, applied)
        self.step += 1

    def heard(self, now_ns: int) -> None:
        """Take note that something has arrived from the ground that is no command."""
        self.executive.heard(now_ns)

    def close(self, now_ns: int) -> None:
        """End, in the log, what is still open at the end of the flight; nobody is told any more."""
        self._closed = True
        self.executive.close(now_ns)

    def log_state(self, now_ns: int) -> None:
        """Log the physics state as it is now."""
        plant = self.plant
        qpos, qvel, warmstart = plant.qpos[0].copy(), plant.qvel[0].copy(), plant.qacc_warmstart[0].copy()
        self._sink(State(now_ns, self.step, qpos, qvel, warmstart))

    def log_checkpoint(self, now_ns: int, link: Mapping[str, object]) -> None:
        """Log all that a replay needs to begin here; `link` is the state of the link."""
        executive = json.dumps(self.executive.state())
        self._sink(Checkpoint(now_ns, self.step, self.plant.integration_state(), executive, json.dumps(link)))

    def _choose(self, now_ns: int) -> tuple[str, FloatArray]:
        if self.executive.on_foot:
            observation = self._layout.observe(self._body, Goals(self.executive.goals, self._noise))
            self._sink(Observation(now_ns, self.step, observation[0]))
            return "policy", self._policy.act(observation)
        if self.executive.mode is Mode.FALLEN:
            return "off", np.zeros((1, self.robot.num_joints))
        return "stance", stance_action(self.robot, self.plant.qpos, self.plant.qvel)

    def _look(self) -> None:
        self._body = body_of(self.plant.qpos, self.plant.qvel)
        self._fell = bool(fallen(self._body, self.robot.fall_height_m, self.robot.fall_up)[0])

    def _log_reward(self, now_ns: int, before: FloatArray, applied: FloatArray) -> None:
        terms = self._pay(before, applied)
        named = tuple(zip(TERMS, terms[0].tolist(), strict=True))
        self._sink(Reward(now_ns, self.step, named, float(np.add.reduce(terms, axis=1)[0])))

    def _pay(self, before: FloatArray, applied: FloatArray) -> FloatArray:
        """Return the terms (1, len(TERMS)) of the control step that has just ended."""
        if self.executive.mode is Mode.FALLEN:
            return _NOTHING  # the fall was paid for in the step that ended in it
        body, approach = self._body, _STILL
        if self.executive.on_foot:
            period_s = self.robot.control_period_ns / 1e9
            approach = progress_speed(before, body.position, self.executive.goals[:, 0], period_s)
        at_limit = self._limits.count(body.joints)
        return reward_terms(self._weights, body, approach, applied, at_limit, np.array([self._fell]))

    def _report(self, stage: CommandStage) -> None:
        self._sink(stage)
        if self._closed:
            return
        if stage.stage in _TOLD_WITH_A_FRAME:
            self._downlink_frame(stage.time_ns)
        self._acknowledge(stage)

    def _acknowledge(self, it: CommandStage) -> None:
        now_ns = it.time_ns
        self._downlink.send(now_ns, lambda arrives_ns: Ack(it.command_id, it.stage, it.reason, now_ns, arrives_ns))

    def _downlink_frame(self, now_ns: int) -> None:
        target = self.executive.target
        velocity = self._body.velocity[0]
        frame = Telemetry(
            frame=self._frame,
            mode=self.executive.mode,
            x_m=float(self._body.position[0, 0]),
            y_m=float(self._body.position[0, 1]),
            z_m=float(self._body.position[0, 2]),
            heading_rad=float(self._body.yaw[0]),
            speed_mps=float(np.hypot(velocity[0], velocity[1])),
            target=-1 if target is None else target.index,
            reached=self.executive.reached,
            issued_ns=now_ns,
            received_ns=now_ns,
        )
        self._frame += 1
        self._downlink.send(now_ns, lambda arrives_ns: replace(frame, received_ns=arrives_ns))
