"""Robots that differ, against one bare world each: its own model, its own queue of commands, its own random stream."""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.sim.bare import BareWorld
from tests.task.views import ANT, view_of
from waypointctl.errors import InputError
from waypointctl.mission.fields import Acceptance, Start
from waypointctl.seeding import stream
from waypointctl.task.batched import BatchedWaypointEnv, Step
from waypointctl.task.config import DomainRandomization, SensorNoise, TaskConfig
from waypointctl.task.course import Course, Deadline
from waypointctl.task.env import WaypointEnv
from waypointctl.task.observation import LAYOUTS
from waypointctl.task.reward import RewardFunction, RewardWeights, progress_speed
from waypointctl.task.view import body_of, fallen

FloatArray = NDArray[np.float64]

SEED = 21
STEPS = 120
ROBOTS = 6
NOISE = SensorNoise(
    joint_angle_rad=0.02,
    joint_speed_radps=0.2,
    position_m=0.03,
    velocity_mps=0.1,
    attitude_rad=0.03,
    gyroscope_radps=0.2,
)
BODIES = DomainRandomization(
    latency_s=(0.0, 0.04), mass_factor=(0.4, 2.5), friction_factor=(0.2, 2.0), gravity_mps2=(1.62, 12.0)
)
ALL = BODIES.model_copy(update={"sensor_noise": NOISE})
ALONE: dict[str, DomainRandomization] = {
    "latency": DomainRandomization(latency_s=(0.0, 0.04)),
    "mass": DomainRandomization(mass_factor=(0.4, 2.5)),
    "friction": DomainRandomization(friction_factor=(0.2, 2.0)),
    "gravity": DomainRandomization(gravity_mps2=(1.62, 12.0)),
    "all": BODIES,
}


def task(randomization: DomainRandomization, observation: str = "egocentric") -> TaskConfig:
    """Return a task whose episodes end often and in every way."""
    return TaskConfig(
        observation=observation,
        reward=RewardWeights(orientation_penalty=0.5, angular_rate_penalty=0.01, fall=10.0),
        course=Course(perimeter="legs", count=2, leg_m=(0.1, 0.9)),
        acceptance=Acceptance(shape="radius", size_m=0.45),
        deadline=Deadline(first_s=0.4, further_s=0.3),
        start=Start(random_heading=True, joint_spread_rad=0.3, speed_spread=1.5),
        domain_randomization=randomization,
    )


def wild(robots: int = ROBOTS, steps: int = STEPS) -> FloatArray:
    """Return actions (steps, robots, 8); a robot's own, however many there are."""
    streams = [np.random.default_rng(100 + robot) for robot in range(robots)]
    return np.stack([0.8 * rng.uniform(-1, 1, 8) + 0.9 * rng.uniform(-1, 1, (steps, 8)) for rng in streams], axis=1)


def walked(config: TaskConfig, robots: int = ROBOTS, threads: int = 0) -> tuple[list[Step], BatchedWaypointEnv]:
    env = BatchedWaypointEnv(config, robots, SEED, threads=threads)
    env.reset()
    return [env.step(action) for action in wild(robots)], env


def between(bounds: tuple[float, float] | None, share: float, otherwise: float) -> float:
    return otherwise if bounds is None else bounds[0] + (bounds[1] - bounds[0]) * share


@dataclass
class Alone:
    """The oracle: one robot in a bare world that is made anew for each episode."""

    randomization: DomainRandomization
    number: int
    actions: list[FloatArray] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.drawing = stream(SEED, "variation", self.number)

    def begin(self, qpos: FloatArray, qvel: FloatArray) -> None:
        latency, mass, friction, gravity = self.drawing.random(4)
        self.world = BareWorld()
        model, told = self.world.model, self.randomization
        factor = between(told.mass_factor, mass, 1.0)
        model.body_mass *= factor
        model.body_inertia *= factor
        mujoco.mj_setConst(model, self.world.data)
        model.geom_friction[:, 0] *= between(told.friction_factor, friction, 1.0)
        model.opt.gravity[2] = -between(told.gravity_mps2, gravity, 9.81)
        self.late = 0 if told.latency_s is None else int(latency * (round(told.latency_s[1] / 0.01) + 1))
        self.queue = [np.zeros(8)] * self.late
        self.world.place(qpos, qvel)

    def step(self, action: FloatArray) -> FloatArray:
        """Walk one control period; return what the motors held at its end."""
        for _ in range(2):
            self.queue.append(np.clip(action, -1.0, 1.0))
            self.world.data.ctrl[:] = self.queue.pop(0)
            mujoco.mj_step(self.world.model, self.world.data)
        held: FloatArray = self.world.data.ctrl.copy()
        return held


def paid(config: TaskConfig, alone: Alone, before: FloatArray, goal: FloatArray, held: FloatArray) -> FloatArray:
    qpos, qvel = alone.world.data.qpos[np.newaxis].copy(), alone.world.data.qvel[np.newaxis].copy()
    body = body_of(qpos, qvel)
    fell = fallen(body, ANT.min_height_m, ANT.min_up)
    approach = progress_speed(before, body.position, goal, 0.02)
    view = view_of(qpos, qvel, action=held[np.newaxis], approach=approach, fell=fell)
    terms: FloatArray = RewardFunction(config.reward).terms(view)[0]
    return terms


@pytest.mark.parametrize("randomization", ALONE.values(), ids=ALONE)
def test_every_robot_goes_and_is_paid_as_in_a_bare_world_of_its_own(randomization: DomainRandomization) -> None:
    config = task(randomization)
    env = BatchedWaypointEnv(config, ROBOTS, SEED)
    env.reset()
    worlds = [Alone(randomization, i) for i in range(ROBOTS)]
    for i, alone in enumerate(worlds):
        alone.begin(env.batch.qpos[i], env.batch.qvel[i])
    episodes = 0
    for action in wild():
        before, goals = env.batch.qpos[:, :2].copy(), env.progress.goals[:, 0].copy()
        step = env.step(action)
        for i, alone in enumerate(worlds):
            held = alone.step(action[i])
            expected = paid(config, alone, before[i : i + 1], goals[i : i + 1], held)
            np.testing.assert_array_equal(step.terms[i], expected)
            if i in step.ended:
                alone.begin(env.batch.qpos[i], env.batch.qvel[i])
                episodes += 1
            else:
                np.testing.assert_array_equal(env.batch.integration[i], alone.world.integration)
    assert episodes > 3 * ROBOTS


def same(first: Step, second: Step, *, seen: bool) -> None:
    for name in ("reward", "terms", "terminated", "truncated", "reached", "success", "ended"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    assert np.array_equal(first.observation, second.observation) == seen


@pytest.mark.parametrize("observation", LAYOUTS)
def test_noise_is_seen_in_every_layout_and_never_paid_for_nor_arrived_by(observation: str) -> None:
    silent, _ = walked(task(BODIES, observation))
    noisy, env = walked(task(ALL, observation))
    assert sum(len(step.ended) for step in silent) > 2 * ROBOTS
    assert any(step.reached.any() for step in silent)
    for quiet, loud in zip(silent, noisy, strict=True):
        same(quiet, loud, seen=False)
        if len(loud.ended):
            assert not np.array_equal(quiet.final_observation, loud.final_observation)
    truth = env.layout.observe(view_of(env.batch.qpos, env.batch.qvel, env.progress.goals, noise=env.noise))
    goal_numbers = [i for i, (name, _, _) in enumerate(env.layout.components) if name in GIVEN]
    off = noisy[-1].observation - truth
    np.testing.assert_array_equal(off[:, goal_numbers], 0.0)
    assert (np.delete(off, goal_numbers, axis=1) != 0).mean() > 0.95  # a distance beyond the range looks the same


# What a policy is told and no sensor measures.
GIVEN = {"current.x", "current.y", "next.x", "next.y", "noise.0", "noise.1", "noise.2", "noise.3"}


def test_noise_has_its_deviation_in_the_observation() -> None:
    robots = 3000
    env = BatchedWaypointEnv(
        TaskConfig(observation="state", domain_randomization=DomainRandomization(sensor_noise=NOISE)), robots, 0
    )
    off = env.reset() - env.layout.observe(view_of(env.batch.qpos, env.batch.qvel, env.progress.goals, noise=env.noise))
    expected = np.repeat([0.02, 0.2, 0.03, 0.1, 0.03], [8, 8, 3, 3, 3])
    np.testing.assert_allclose(off.std(axis=0), expected, rtol=0.08)


def test_letting_one_thing_vary_shifts_nothing_else_that_is_drawn() -> None:
    def drawn(randomization: DomainRandomization) -> dict[str, FloatArray]:
        env = BatchedWaypointEnv(task(randomization), ROBOTS, SEED)
        for _ in range(3):
            env.reset()
        every = {"start": env.batch.qpos.copy(), "course": env.progress.waypoints.copy(), "noise": env.noise.copy()}
        return every | env.randomized.values(np.arange(ROBOTS))

    everything = drawn(ALL)
    assert len(everything) == 7
    for randomization in (DomainRandomization(), *ALONE.values(), DomainRandomization(sensor_noise=NOISE)):
        for name, values in drawn(randomization).items():
            np.testing.assert_array_equal(values, everything[name])


def test_a_robot_draws_the_same_whatever_the_others_do_and_anew_for_each_episode() -> None:
    few, many = (BatchedWaypointEnv(task(BODIES), robots, SEED) for robots in (2, 5))
    seen = []
    for env, late in ((few, 0), (many, 30)):
        env.reset()
        first = env.randomized.values(np.array([1]))
        for action in wild(env.num_robots)[:late]:
            env.step(action)
        env = BatchedWaypointEnv(task(BODIES), env.num_robots, SEED, autoreset=False)
        env.reset()
        env.begin([1])
        second = env.randomized.values(np.array([1]))
        assert all(first[name] != second[name] for name in ("mass_factor", "friction_factor", "gravity_mps2"))
        seen.append((first, second))
    assert seen[0] == seen[1]


NOTHING_NEW = DomainRandomization(
    latency_s=(0.0, 0.0),
    mass_factor=(1.0, 1.0),
    friction_factor=(1.0, 1.0),
    gravity_mps2=(9.81, 9.81),
    sensor_noise=SensorNoise(),
)


def test_bounds_at_the_models_own_values_change_no_bit() -> None:
    for plain, varied in zip(walked(task(DomainRandomization()))[0], walked(task(NOTHING_NEW))[0], strict=True):
        same(plain, varied, seen=True)


def test_where_nothing_varies_nothing_is_drawn_kept_or_changed() -> None:
    _, env = walked(task(DomainRandomization()))
    assert env.randomized.state() == {}
    assert env.randomized.values(np.arange(ROBOTS)) == {}


@pytest.mark.parametrize("threads", [1, 2])
def test_a_batch_put_into_the_state_of_another_goes_on_bit_for_bit(threads: int) -> None:
    _, env = walked(task(ALL), threads=threads)
    other = BatchedWaypointEnv(task(ALL), ROBOTS, SEED + 1, threads=threads)
    other.reset()
    other.randomized.restore({name: array.copy() for name, array in env.randomized.state().items()})
    other.batch.integration[:] = env.batch.integration
    other.noise[:] = env.noise
    for name, array in vars(env.progress).items():
        if isinstance(array, np.ndarray):
            getattr(other.progress, name)[:] = array
    other.starts, other.courses = env.starts, env.courses
    streams = [(rng, rng.bit_generator.state) for rng in (*env.starts, *env.courses)]
    expected = [env.step(action) for action in wild()]
    for rng, state in streams:
        rng.bit_generator.state = state
    assert sum(len(step.ended) for step in expected) > ROBOTS
    for step, action in zip(expected, wild(), strict=True):
        same(step, other.step(action), seen=True)


def test_the_gymnasium_env_is_the_batch_of_one_and_says_what_was_drawn() -> None:
    env, batched = WaypointEnv(task(ALL)), BatchedWaypointEnv(task(ALL), 1, 5, autoreset=False)
    for seed in (5, None, None):
        observation, info = env.reset(seed=seed)
        np.testing.assert_array_equal(observation, batched.reset()[0])
        drawn = batched.randomized.values(np.array([0]))
        assert {name: info[name] for name in drawn} == {name: value[0] for name, value in drawn.items()}
        assert set(drawn) == {"latency_s", "mass_factor", "friction_factor", "gravity_mps2"}
        for action in wild(1)[:20]:
            step = batched.step(action.astype(np.float32).astype(np.float64))
            observation, reward, *_ = env.step(action[0].astype(np.float32))
            np.testing.assert_array_equal(observation, step.observation[0])
            assert reward == step.reward[0]
    first = env.reset(seed=5)
    again = env.reset(seed=5)
    np.testing.assert_array_equal(first[0], again[0])


PATH = np.array([[0.5, 0.2], [0.7, -0.5], [-0.6, 0.1]])


def test_a_given_path_is_walked_to_its_end_and_beyond_by_robots_that_differ() -> None:
    def places(randomization: DomainRandomization) -> FloatArray:
        env = BatchedWaypointEnv(task(randomization), ROBOTS, SEED, max_waypoints=3, autoreset=False)
        env.begin(range(ROBOTS), PATH)
        drawn = env.randomized.values(np.arange(ROBOTS))
        ended = np.concatenate([env.step(action).ended for action in wild()])
        assert set(ended) == set(range(ROBOTS))
        np.testing.assert_array_equal(env.progress.waypoints, np.stack([PATH] * ROBOTS))
        for name, value in env.randomized.values(np.arange(ROBOTS)).items():
            np.testing.assert_array_equal(value, drawn[name])
        return env.batch.qpos[:, :2].copy()

    plain, varied, again = places(DomainRandomization()), places(ALL), places(ALL)
    np.testing.assert_array_equal(varied, again)
    assert not np.isclose(plain, varied).any()


def test_a_latency_that_the_robot_cannot_have_is_refused() -> None:
    with pytest.raises(InputError, match=r"domain_randomization: latency: 5 ms is not a whole number"):
        BatchedWaypointEnv(task(DomainRandomization(latency_s=(0.005, 0.04))), 1, 0)
