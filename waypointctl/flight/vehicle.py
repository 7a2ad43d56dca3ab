"""The robot in flight: its physics, its executive, its policy, and what it reports."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.executive.executive import Executive
from waypointctl.flight.executive.rules import Rules
from waypointctl.flight.link.frames import ControlFrame, Heartbeat
from waypointctl.flight.navigator import DirectNavigator, Navigator, sound_goals
from waypointctl.flight.policy_fit import chosen_action, reward_weights
from waypointctl.flight.reporter import Reporter
from waypointctl.flight.sink import Sink
from waypointctl.log.messages import (
    FINAL_STAGES,
    Action,
    Checkpoint,
    Clock,
    Command,
    CommandStage,
    Event,
    EventKind,
    Mode,
    Observation,
    Reward,
    Severity,
    Stage,
    State,
)
from waypointctl.policy.protocol import Policy, state_text
from waypointctl.robots.robot import Robot, stance_action
from waypointctl.sim.actions import clip_actions
from waypointctl.sim.stepping import SingleRobot
from waypointctl.task.observation import NOISE_SIZE, layout
from waypointctl.task.plugins import Plugin
from waypointctl.task.reward import RewardFunction, progress_speed
from waypointctl.task.view import Body, SimulationView, body_of, fallen
from waypointctl.units import NS_PER_S

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

_STILL: Final = np.zeros(1)

STILL_SPEED: Final = 1e-2  # [m/s, rad/s] of every part; slower is standing still
# Teleoperation times out after this long without an action from the ground.
TELEOPERATION_TIMEOUT_NS: Final = 60 * NS_PER_S
REST_AFTER_NS: Final = 10 * NS_PER_S  # a robot that has stood still for this long rests: physics sleeps

# The end of a command is reported after a frame of telemetry: the operator knows the waypoints before the result.
_TOLD_WITH_A_FRAME: Final = FINAL_STAGES - {Stage.REJECTED, Stage.SKIPPED}


class Vehicle:
    """One robot that executes commands. It gets the time with each call."""

    def __init__(
        self,
        robot: Robot,
        policy: Policy,
        sink: Sink,
        reporter: Reporter,
        rules: Rules,
        navigator: Navigator | None = None,
        plugins: Sequence[Plugin] = (),
    ) -> None:
        """Make a robot that reports to the ground and logs its truth into `sink`; `place` it before flight."""
        self.robot = robot
        self.plant = SingleRobot(robot)
        self.executive = Executive(self._report, sink, remind=reporter.acknowledge, rules=rules)
        self.step = 0
        self._policy = policy
        self._navigator = navigator or DirectNavigator()
        self._goals: FloatArray = np.zeros((1, 2, 2))  # the policy's goals
        self._layout = layout(policy.observation_layout, robot, plugins)
        self._reward = RewardFunction(reward_weights(policy, plugins), plugins)
        self._no_reward: FloatArray = np.zeros((1, len(self._reward.names)))
        self._applied: FloatArray = np.zeros((1, robot.num_actions))
        self._sink = sink
        self._reporter = reporter
        self._control: FloatArray = np.zeros((1, robot.num_actions))  # the newest action from the ground
        self._control_step = -1  # whose state it was computed from
        self._control_ns = 0  # when it arrived
        self._moved_ns = 0  # when it last did
        self._rests = False
        self._body: Body = body_of(self.plant.qpos, self.plant.qvel)
        self._fell = False
        self._closed = False
        self._noise: FloatArray = np.zeros((1, NOISE_SIZE))

    def place(self, qpos: FloatArray, qvel: FloatArray, noise: FloatArray) -> None:
        """Put the robot where the mission begins: qpos (nq,), qvel (nv,); noise (4,) is for layouts that have some."""
        self._noise = noise[np.newaxis]
        self._policy.reset(np.ones(1, bool))
        self.plant.place(qpos[np.newaxis], qvel[np.newaxis])
        self._observe()

    def execute(self, now_ns: int, arrived: Command | ControlFrame | Heartbeat) -> None:
        """Take what has arrived: a command, an action from the ground, or a sign of life."""
        if isinstance(arrived, ControlFrame):
            if arrived.step > self._control_step:  # ignore actions that arrive out of order
                self._control, self._control_step = arrived.values[np.newaxis], arrived.step
                self._control_ns = now_ns
            self.executive.on_action(now_ns)
            return
        if isinstance(arrived, Heartbeat):
            self.executive.on_contact(now_ns)
            return
        self.executive.execute(now_ns, arrived)
        self._reporter.frame(now_ns, self.executive, self._body)

    def sense(self, now_ns: int) -> None:
        """Update the executive with the robot's state; report at the telemetry rate and on changes."""
        if self.executive.mode is Mode.TELEOPERATED and now_ns - self._control_ns >= TELEOPERATION_TIMEOUT_NS:
            self.executive.release()
        self.executive.sense(now_ns, self._body.position, self._fell, float(self._body.yaw[0]))
        if self._reporter.frame_if_due(now_ns, self.executive, self._body):
            if self._rests:
                self._reporter.put_off(now_ns)
        elif self._reporter.changes.unreported(self.executive):
            self._reporter.frame(now_ns, self.executive, self._body)
        self._reporter.state(now_ns, self.step, self.plant)

    def rests(self, now_ns: int) -> bool:
        """Return whether the robot has stood still for so long that its physics can sleep until something happens."""
        still = self.is_still(now_ns)
        if still != self._rests:
            self._rests = still
            kind, text = (
                (EventKind.REST_STARTED, "robot at rest: simulation skips to the next event")
                if still
                else (EventKind.REST_ENDED, "simulation continues")
            )
            self._sink(Event(now_ns, kind, Clock.ROBOT, Severity.INFO, text))
            if still:
                self._reporter.put_off(now_ns)
            else:
                self._reporter.resume(now_ns)
        return still

    def is_still(self, now_ns: int) -> bool:
        """Return the same, without recording it."""
        if self._reporter.every_state and now_ns - self._control_ns < TELEOPERATION_TIMEOUT_NS:
            return False  # teleoperation needs every state
        return not self._driven and now_ns - self._moved_ns >= REST_AFTER_NS

    @property
    def _driven(self) -> bool:
        """Whether a policy has the motors, here or on the ground."""
        return self.executive.policy_active or self.executive.mode is Mode.TELEOPERATED

    def next_ns(self, now_ns: int) -> int:
        """Return when a robot that rests has something to do by itself [ns]: a beacon at the latest."""
        due_ns = self.executive.next_ns(now_ns)
        return self._reporter.next_ns if due_ns is None else min(due_ns, self._reporter.next_ns)

    def act(self, now_ns: int) -> None:
        """Log the state, choose an action, apply it for one control period, log its reward."""
        self.log_state(now_ns)
        source, commanded = self._choose(now_ns)
        applied = clip_actions(commanded)
        self._sink(Action(now_ns, self.step, source, commanded[0], applied[0]))
        before = self.plant.qpos[:, :2].copy()
        self.plant.step(applied)
        self._observe()
        self._applied = applied
        self._log_reward(now_ns, before)
        self.step += 1
        if self._driven or np.abs(self.plant.qvel[0]).max() > STILL_SPEED:
            self._moved_ns = now_ns + self.robot.control_period_ns

    def close(self, now_ns: int) -> None:
        """Log the end of every command still open at the end of the flight; no acknowledgement is sent."""
        self._closed = True
        self.executive.close(now_ns)

    def log_state(self, now_ns: int) -> None:
        """Log the physics state as it is now."""
        plant = self.plant
        qpos, qvel, warmstart = plant.qpos[0].copy(), plant.qvel[0].copy(), plant.qacc_warmstart[0].copy()
        self._sink(State(now_ns, self.step, qpos, qvel, warmstart))

    def log_checkpoint(self, now_ns: int, link: Mapping[str, object]) -> None:
        """Log all that a replay needs to begin here; `link` is the state of the link."""
        navigator = self._navigator.state()
        executive = json.dumps(self.executive.state() | ({"navigator": navigator} if navigator else {}))
        integration, policy = self.plant.integration_state(), state_text(self._policy.state())
        self._sink(Checkpoint(now_ns, self.step, integration, executive, json.dumps(link), policy))

    def _choose(self, now_ns: int) -> tuple[str, FloatArray]:
        if self.executive.policy_active:
            self._goals = sound_goals(self._navigator.goals(self._body, self.executive.goals))
            observation = self._layout.observe(self._view(now_ns))
            self._sink(Observation(now_ns, self.step, observation[0]))
            return "policy", chosen_action(self._policy, observation, self.robot.num_actions)
        if self.executive.mode is Mode.TELEOPERATED:
            return "ground", self._control
        if self.executive.mode is Mode.FALLEN:
            return "off", np.zeros((1, self.robot.num_actions))
        return "stance", stance_action(self.robot, self.plant.qpos, self.plant.qvel)

    def _observe(self) -> None:
        self._body = body_of(self.plant.qpos, self.plant.qvel)
        self._fell = bool(fallen(self._body, self.robot.min_height_m, self.robot.min_up)[0])

    def _view(self, now_ns: int, approach: FloatArray | None = None, fell: BoolArray | None = None) -> SimulationView:
        return SimulationView(
            robot=self.robot,
            body=self._body,
            qpos=self.plant.qpos,
            goals=self._goals,
            noise=self._noise,
            action=self._applied,
            steps=np.array([now_ns // self.robot.control_period_ns]),
            approach=approach,
            fell=fell,
        )

    def _log_reward(self, begun_ns: int, before: FloatArray) -> None:
        """Log the reward of the control period that began at a time and has just ended."""
        terms = self._rewards(begun_ns, before)
        now_ns = begun_ns + self.robot.control_period_ns
        named = tuple(zip(self._reward.names, terms[0].tolist(), strict=True))
        self._sink(Reward(now_ns, self.step, named, float(np.add.reduce(terms, axis=1)[0])))

    def _rewards(self, begun_ns: int, before: FloatArray) -> FloatArray:
        """Return the terms (1, k) of the control step that has just ended."""
        if self.executive.mode is Mode.FALLEN:
            return self._no_reward  # the step that ended in the fall had its cost
        body, approach = self._body, _STILL
        if self.executive.policy_active:
            period_s = self.robot.control_period_ns / 1e9
            approach = progress_speed(before, body.position, self._goals[:, 0], period_s)
        return self._reward.terms(self._view(begun_ns, approach, np.array([self._fell])))

    def _report(self, stage: CommandStage) -> None:
        self._sink(stage)
        if self._closed:
            return
        if stage.stage in _TOLD_WITH_A_FRAME:
            self._reporter.frame(stage.time_ns, self.executive, self._body)
        self._reporter.acknowledge(stage)
