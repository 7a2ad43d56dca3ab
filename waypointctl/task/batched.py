"""Many robots on their courses, stepped in one call."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import given_number, wrong_type
from waypointctl.robots.load import given_robot
from waypointctl.seeding import stream
from waypointctl.sim.actions import clip_actions, refuse_bad_action
from waypointctl.sim.stepping import RobotBatch
from waypointctl.task.config import TaskConfig, draw_start
from waypointctl.task.observation import NOISE_SIZE, layout
from waypointctl.task.progress import CourseProgress, FailedCourses
from waypointctl.task.randomized_robots import RandomizedRobots
from waypointctl.task.reward import RewardFunction, progress_speed
from waypointctl.task.view import Body, SimulationView, body_of, fallen

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

Robots: TypeAlias = NDArray[np.intp] | slice


@dataclass(frozen=True, slots=True)
class Step:
    """The result of one control step of n robots.

    An episode ends *terminated* by a fall, *truncated* by its deadline or by reaching the last waypoint: success
    is not a terminal state, since the return of the following steps would be lost.

    Attributes:
        observation: (n, k) for the next action; of the new episode where one began.
        reward: (n,) the sum of `terms`.
        terms: (n, k) weighted, named by `reward.names` of the env.
        terminated: (n,) bool.
        truncated: (n,) bool.
        reached: (n,) bool, a waypoint was reached.
        success: (n,) bool, it was the last.
        ended: ids (e,) of the robots whose episode ended.
        final_observation: (e, k) the last observations of the robots in `ended`.
    """

    observation: FloatArray
    reward: FloatArray
    terms: FloatArray
    terminated: BoolArray
    truncated: BoolArray
    reached: BoolArray
    success: BoolArray
    ended: NDArray[np.intp]
    final_observation: FloatArray


class BatchedWaypointEnv:
    """N robots, each on its own course, stepped on all cores.

    Robot i draws its starts from stream(seed, "start", i) and its courses from stream(seed, "course", i), whatever
    the other robots do; with failure replay it keeps its own failed courses. Noisy sensors alone draw for all
    robots together.
    """

    def __init__(
        self,
        config: TaskConfig,
        num_robots: int,
        seed: int,
        *,
        threads: int = 0,
        max_waypoints: int | None = None,
        autoreset: bool = True,
    ) -> None:
        """Make the worlds; `reset` before the first step.

        Args:
            config: the task.
            num_robots: how many.
            seed: of every random stream.
            threads: physics threads; 0 is one per core, 8 at most.
            max_waypoints: the longest course for `begin`; default: that of the config.
            autoreset: begin a new episode in the step that ends one; without it, ended robots continue to move.

        Raises:
            RobotError: there is no such robot, or it is wrong.
            InputError: an argument has a wrong type or is out of bounds, or the task names what there is not.
        """
        if not isinstance(config, TaskConfig):
            raise wrong_type("config", config, "a TaskConfig")
        num_robots = given_number("num_robots", num_robots, 1, 2**20)
        seed, threads = given_number("seed", seed, 0, 2**63 - 1), given_number("threads", threads, 0, 1024)
        self.config = config
        self.robot = given_robot(config.robot)
        self.layout = layout(config.observation, self.robot, config.plugins)
        self.num_robots = num_robots
        self.batch = RobotBatch(self.robot, num_robots, threads)
        self.randomized = RandomizedRobots(config.domain_randomization, self.batch)
        self.progress = CourseProgress(
            num_robots, max_waypoints or config.course.longest, config.deadline, self.robot.control_period_ns
        )
        self.noise: FloatArray = np.zeros((num_robots, NOISE_SIZE))
        self.action: FloatArray = np.zeros((num_robots, self.robot.num_actions))
        self.seed(seed)
        self._autoreset = autoreset
        self._period_s = self.robot.control_period_ns / 1e9

    @property
    def config(self) -> TaskConfig:
        """The task; robot, observation, deadline and domain randomization stay those of the first one."""
        return self._config

    @config.setter
    def config(self, config: TaskConfig) -> None:
        self._config = config
        self.reward = RewardFunction(config.reward, config.plugins)

    def seed(self, seed: int) -> None:
        """Begin every random stream anew, and forget the courses that failed."""
        self.starts = [stream(seed, "start", i) for i in range(self.num_robots)]
        self.courses = [stream(seed, "course", i) for i in range(self.num_robots)]
        self.randomized.seed(seed)
        replay, longest = self.config.failure_replay, self.config.course.longest
        self.failed = FailedCourses(replay, self.num_robots, longest, seed) if replay.probability else None

    def reset(self) -> FloatArray:
        """Begin a new episode with every robot; return the observations (n, k)."""
        self.begin(range(self.num_robots))
        return self.observe()

    def begin(self, robots: Sequence[int] | NDArray[np.intp], waypoints: FloatArray | None = None) -> None:
        """Begin a new episode with some robots, on a given course (m, 2) or on one drawn for each."""
        states = [draw_start(self.config.start, self.robot, self.starts[i]) for i in robots]
        qpos, qvel = (np.stack(part) for part in zip(*states, strict=True))
        ids = np.asarray(robots, np.intp)
        self.batch.place(ids, qpos, qvel)
        self.randomized.begin(ids)
        for i, start in zip(robots, qpos, strict=True):
            rng = self.courses[i]
            self.progress.assign(i, self._course(i, start[:2]) if waypoints is None else waypoints)
            if self.failed is not None and waypoints is not None:
                self.failed.given(i)
            self.noise[i] = rng.uniform(-1.0, 1.0, NOISE_SIZE)
            self.action[i] = 0.0

    def observe(self) -> FloatArray:
        """Return the current observations, (n, k)."""
        return self._observation(self._body(slice(None)), slice(None))

    def step(self, actions: FloatArray) -> Step:
        """Step one control period with actions (n, nu), clipped to [-1, 1].

        Raises:
            InputError: the actions have another shape, or a number that is not finite.
        """
        actions = refuse_bad_action(actions, self.robot.num_actions, self.num_robots)
        before = self.batch.qpos[:, :2].copy()
        self.action = clip_actions(actions)
        held = self.randomized.step(self.action)

        body = self._body(slice(None))
        fell = fallen(body, self.robot.min_height_m, self.robot.min_up)
        approach = progress_speed(before, body.position, self.progress.goals[:, 0], self._period_s)
        terms = self.reward.terms(self._rewarded(body, held, approach, fell))

        advance = self.progress.advance(self.config.acceptance, body.position)
        success = advance.finished & ~fell
        truncated = (success | advance.timed_out) & ~fell
        observation = self._observation(body, slice(None))
        ended = np.flatnonzero(fell | truncated)
        final_observation = observation[ended]
        if self.failed is not None:
            self.failed.ended(ended, success[ended], self.progress)
        if self._autoreset and len(ended):
            self.begin(ended)
            observation[ended] = self._observation(self._body(ended), ended)
        return Step(
            observation=observation,
            reward=np.add.reduce(terms, axis=1),
            terms=terms,
            terminated=fell,
            truncated=truncated,
            reached=advance.reached,
            success=success,
            ended=ended,
            final_observation=final_observation,
        )

    def _course(self, robot: int, start: FloatArray) -> FloatArray:
        """Return a course for a new episode: one that failed, or one just drawn."""
        again = None if self.failed is None else self.failed.choose(robot)
        return self.config.course.draw(self.courses[robot], start) if again is None else again

    def _body(self, robots: Robots) -> Body:
        # Copies, column by column: in the batch's memory a robot's state is not contiguous.
        return body_of(self.batch.qpos[robots].copy(order="F"), self.batch.qvel[robots].copy(order="F"))

    def _observation(self, body: Body, robots: Robots) -> FloatArray:
        view = SimulationView(
            robot=self.robot,
            body=self.randomized.seen(body),
            qpos=self.batch.qpos[robots],
            goals=self.progress.goals[robots],
            noise=self.noise[robots],
            action=self.action[robots],
            steps=self.progress.steps[robots],
        )
        return self.layout.observe(view)

    def _rewarded(self, body: Body, held: FloatArray, approach: FloatArray, fell: BoolArray) -> SimulationView:
        """Return the true state after a control period, with the waypoint that was current."""
        return SimulationView(
            robot=self.robot,
            body=body,
            qpos=self.batch.qpos,
            goals=self.progress.goals,
            noise=self.noise,
            action=held,
            steps=self.progress.steps,
            approach=approach,
            fell=fell,
        )
