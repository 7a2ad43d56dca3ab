from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.sim.bare import BareWorld
from tests.task.views import ANT, view_of
from waypointctl.errors import InputError
from waypointctl.mission.fields import Acceptance, Start
from waypointctl.robots.load import load_robot
from waypointctl.seeding import stream
from waypointctl.task.batched import BatchedWaypointEnv, Step
from waypointctl.task.config import TaskConfig, draw_start
from waypointctl.task.course import Course, Deadline
from waypointctl.task.observation import layout
from waypointctl.task.reward import RewardFunction, RewardWeights, progress_speed
from waypointctl.task.view import body_of, fallen

FloatArray = NDArray[np.float64]

SEED = 11
STEPS = 150
ROBOTS = 6


def busy(observation: str = "egocentric") -> TaskConfig:
    """Return a task whose episodes end often and in every way: falls, deadlines and successes."""
    return TaskConfig(
        observation=observation,
        reward=RewardWeights(progress_cap_mps=1.0, orientation_penalty=0.5, angular_rate_penalty=0.01, fall=10.0),
        course=Course(perimeter="legs", count=3, leg_m=(0.1, 0.9)),
        acceptance=Acceptance(shape="radius", size_m=0.45),
        deadline=Deadline(first_s=0.5, further_s=0.4),
        start=Start(random_heading=True, joint_spread_rad=0.3, speed_spread=1.5),
    )


def drawn_actions(robot: int) -> FloatArray:
    """Return wild actions (STEPS, 8), some beyond what the motors can; a robot's own, however many there are."""
    rng = np.random.default_rng(1000 + robot)
    strength = np.where(robot % 2, 1.6, 0.4)
    return strength * rng.uniform(-1, 1, 8) + 0.5 * rng.uniform(-1, 1, (STEPS, 8))


@dataclass
class Alone:
    """The oracle: one robot in a bare mj_step loop, with the task's pure functions and its own book-keeping."""

    config: TaskConfig
    number: int
    world: BareWorld = field(default_factory=BareWorld)

    def __post_init__(self) -> None:
        self.starts, self.courses = stream(SEED, "start", self.number), stream(SEED, "course", self.number)
        self.robot = load_robot("ant")
        self.begin()

    def begin(self) -> None:
        qpos, qvel = draw_start(self.config.start, self.robot, self.starts)
        self.world.place(qpos, qvel)
        self.waypoints = self.config.course.draw(self.courses, qpos[:2])
        self.noise = self.courses.uniform(-1.0, 1.0, (1, 4))
        self.index, self.steps = 0, 0
        self.limit_s = self.config.deadline.first_s

    @property
    def goals(self) -> FloatArray:
        following = min(self.index + 1, len(self.waypoints) - 1)
        goals: FloatArray = self.waypoints[[self.index, following]][np.newaxis]
        return goals

    def observe(self) -> FloatArray:
        data = self.world.data
        view = view_of(data.qpos[np.newaxis], data.qvel[np.newaxis], self.goals, noise=self.noise)
        observation: FloatArray = layout(self.config.observation, ANT).observe(view)[0]
        return observation

    def step(self, action: FloatArray) -> dict[str, object]:
        applied, goal = np.clip(action, -1.0, 1.0), self.goals[:, 0]
        before = self.world.data.qpos[np.newaxis, :2].copy()
        self.world.step(applied)
        self.steps += 1
        qpos, qvel = self.world.data.qpos[np.newaxis].copy(), self.world.data.qvel[np.newaxis].copy()
        body = body_of(qpos, qvel)
        fell = fallen(body, self.robot.min_height_m, self.robot.min_up)
        approach = progress_speed(before, body.position, goal, 0.02)
        view = view_of(qpos, qvel, action=applied[np.newaxis], approach=approach, fell=fell)
        terms = RewardFunction(self.config.reward).terms(view)[0]
        there = bool(np.hypot(*(body.position[0, :2] - goal[0])) < self.config.acceptance.size_m)
        last = self.index == len(self.waypoints) - 1
        if there:
            self.limit_s += self.config.deadline.further_s
            self.index += not last
        late = self.steps >= round(self.limit_s / 0.02) and not (there and last)
        return {
            "terms": terms,
            "reached": there,
            "terminated": bool(fell[0]),
            "success": there and last and not fell[0],
            "truncated": ((there and last) or late) and not fell[0],
            "final": self.observe(),
        }


@pytest.mark.parametrize("name", ["state_noise", "egocentric"])
def test_every_robot_goes_as_it_goes_alone_in_a_bare_mj_step_loop(name: str) -> None:
    config = busy(name)
    env = BatchedWaypointEnv(config, ROBOTS, SEED, threads=2)
    alone = [Alone(config, i) for i in range(ROBOTS)]
    np.testing.assert_array_equal(env.reset(), np.stack([one.observe() for one in alone]))
    actions = np.stack([drawn_actions(i) for i in range(ROBOTS)], axis=1)
    falls = late = successes = 0
    for step_actions in actions:
        step = env.step(step_actions)
        for i, one in enumerate(alone):
            expected = one.step(step_actions[i])
            np.testing.assert_array_equal(step.terms[i], expected["terms"])
            for name in ("reached", "terminated", "truncated", "success"):
                assert getattr(step, name)[i] == expected[name]
            ended = expected["terminated"] or expected["truncated"]
            assert (i in step.ended) == ended
            if ended:
                final = step.final_observation[step.ended.tolist().index(i)]
                np.testing.assert_array_equal(final, expected["final"])
                one.begin()
            np.testing.assert_array_equal(step.observation[i], one.observe())
            np.testing.assert_array_equal(env.batch.integration[i], one.world.integration)
        falls += int(step.terminated.sum())
        successes += int(step.success.sum())
        late += int((step.truncated & ~step.success).sum())
    assert min(falls, late, successes) >= 1, f"{falls} falls, {late} late, {successes} successes: not every end was met"


def steps_of(robots: int, threads: int) -> list[Step]:
    env = BatchedWaypointEnv(busy(), robots, SEED, threads=threads)
    env.reset()
    actions = np.stack([drawn_actions(i) for i in range(robots)], axis=1)
    return [env.step(each) for each in actions]


@pytest.mark.parametrize(("robots", "threads"), [(1, 1), (9, 1), (40, 3)])
def test_a_robot_does_not_notice_how_many_there_are_nor_the_threads(robots: int, threads: int) -> None:
    shared = min(robots, 3)
    for here, there in zip(steps_of(3, 1), steps_of(robots, threads), strict=True):
        for name in ("observation", "terms", "reward", "terminated", "truncated", "reached", "success"):
            np.testing.assert_array_equal(getattr(there, name)[:shared], getattr(here, name)[:shared])


def test_the_reward_is_the_sum_of_its_terms() -> None:
    for step in steps_of(5, 1)[:50]:
        np.testing.assert_allclose(step.reward, [sum(terms) for terms in step.terms.tolist()], atol=1e-12)


def test_success_is_truncated_and_begins_a_new_episode() -> None:
    env = BatchedWaypointEnv(TaskConfig(acceptance=Acceptance(shape="box", size_m=2.0)), 3, 0, max_waypoints=4)
    env.reset()
    env.begin([1], np.array([[1.0, 0.0], [0.0, 1.0]]))
    first, second = env.step(np.zeros((3, 8))), env.step(np.zeros((3, 8)))
    assert (first.reached.tolist(), first.ended.tolist()) == ([False, True, False], [])
    assert second.success.tolist() == second.truncated.tolist() == [False, True, False]
    assert not second.terminated.any()
    assert second.ended.tolist() == [1]
    assert second.final_observation.shape == (1, 31)
    assert env.progress.index[1] == 0
    assert env.progress.steps.tolist() == [2, 0, 2]
    np.testing.assert_array_equal(env.observe(), second.observation)
    assert not np.array_equal(second.final_observation[0], second.observation[1])


def test_without_autoreset_a_robot_that_has_ended_walks_on() -> None:
    env = BatchedWaypointEnv(TaskConfig(deadline=Deadline(first_s=0.04, further_s=1.0)), 2, 0, autoreset=False)
    env.reset()
    env.step(np.zeros((2, 8)))
    late = env.step(np.zeros((2, 8)))
    assert late.ended.tolist() == [0, 1]
    np.testing.assert_array_equal(late.final_observation, late.observation)
    assert env.progress.steps.tolist() == [2, 2]
    assert env.step(np.zeros((2, 8))).truncated.all()


def test_a_robots_second_episode_does_not_depend_on_when_it_begins() -> None:
    seen = []
    for late in (0, 25):
        env = BatchedWaypointEnv(TaskConfig(), 2, 3)
        env.reset()
        for _ in range(late):
            env.step(np.zeros((2, 8)))
        env.begin([1])
        seen.append((env.observe()[1], env.progress.waypoints[1].copy()))
    for first, second in zip(*seen, strict=True):
        np.testing.assert_array_equal(first, second)


def test_names_that_do_not_exist_are_refused() -> None:
    with pytest.raises(InputError, match="there is no robot 'rover'"):
        BatchedWaypointEnv(TaskConfig(robot="rover"), 1, 0)
    with pytest.raises(InputError, match="unknown observation layout 'pixels'"):
        BatchedWaypointEnv(TaskConfig(observation="pixels"), 1, 0)


@pytest.mark.parametrize(
    ("actions", "problem"),
    [
        (np.zeros((2, 8)), r"the actions must have the shape \(3, 8\), not \(2, 8\)"),
        (np.zeros(8), r"the actions must have the shape \(3, 8\), not \(8,\)"),
        (np.where(np.arange(24).reshape(3, 8) == 13, np.nan, 0.0), r"must be finite: joint 5 of robot 1 is nan"),
    ],
)
def test_actions_that_are_none_are_refused(actions: FloatArray, problem: str) -> None:
    env = BatchedWaypointEnv(TaskConfig(), 3, 0)
    env.reset()
    with pytest.raises(InputError, match=problem):
        env.step(actions)
