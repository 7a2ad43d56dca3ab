"""Hashes of what flights, evaluations, the batched environment and the learner come to, number by number.

    python -m tests.golden.recording > tests/golden/golden.json

writes them anew. That is for a change that is meant to change the numbers; DECISIONS.md then says which and why.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, Final

import mujoco
import numpy as np
from numpy.typing import NDArray

from waypointctl.evaluation.evaluate import evaluate
from waypointctl.evaluation.suite import BUILT_IN, load_suite
from waypointctl.flight.fly import fly
from waypointctl.log.messages import (
    Ack,
    Action,
    Command,
    GroundControl,
    LinkRecord,
    Message,
    Observation,
    Reward,
    State,
    Telemetry,
)
from waypointctl.mission.files import load_mission
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.robots.load import load_robot
from waypointctl.task.batched import BatchedWaypointEnv, Step
from waypointctl.task.config import DomainRandomization, FailureReplay, SensorNoise, TaskConfig
from waypointctl.task.course import Course
from waypointctl.task.observation import layout
from waypointctl.task.view import SimulationView, body_of
from waypointctl.training.recipe_file import load_recipe

ROOT: Final = Path(__file__).parents[2]
MISSIONS: Final = tuple(sorted(path.stem for path in (ROOT / "missions").glob("*.yaml")))
POLICIES: Final = tuple(sorted(path.parent.name for path in (ROOT / "policies").glob("*/manifest.json")))
LAYOUTS: Final = ("state", "state_noise", "state_goal", "egocentric")


class Digest:
    """A running SHA-256 of numbers: float64, little-endian, each array after its shape."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def add(self, *values: Any) -> None:
        for value in values:
            numbers = np.ascontiguousarray(value, dtype="<f8")
            self._hash.update(np.asarray(numbers.shape, "<i8").tobytes() + numbers.tobytes())

    def __str__(self) -> str:
        return self._hash.hexdigest()[:32]


def machine() -> str:
    """Return a hash of arithmetic that is none of waypointctl's: other processors and versions come to other bits."""
    digest, rng = Digest(), np.random.default_rng(0)
    matrix = rng.standard_normal((256, 256))
    digest.add(matrix @ matrix, np.tanh(matrix), np.exp(matrix), np.sin(matrix), np.arctan2(matrix, matrix.T))
    model = mujoco.MjModel.from_xml_path(str(ROOT / "tests" / "golden" / "canary.xml"))
    data = mujoco.MjData(model)
    for step in range(200):
        data.ctrl[:] = np.sin(0.1 * step + np.arange(model.nu))
        mujoco.mj_step(model, data)
    digest.add(data.qpos, data.qvel)
    network = load_policy(ROOT / "policies" / "ant-waypoint").network
    digest.add(network.run(rng.standard_normal((64, network.input_size))))
    return str(digest)


def _numbers(message: Message) -> tuple[Any, ...]:
    """Return the stream that a message belongs to and the numbers of it that are hashed; nothing of the other kinds."""
    match message:
        case State():
            return "state", message.time_ns, message.qpos, message.qvel, message.qacc_warmstart
        case Observation():
            return "observation", message.time_ns, message.values
        case Action():
            return "action", message.time_ns, message.commanded, message.applied
        case Reward():
            return "reward", message.time_ns, [value for _, value in message.terms], message.total
        case Command():
            return "delivery", 0, message.id, message.attempt, message.issued_ns, message.received_ns
        case Ack():
            return "delivery", 1, message.command_id, message.issued_ns, message.received_ns
        case Telemetry():
            return "delivery", 2, message.frame, message.issued_ns, message.received_ns, message.x_m
        case GroundControl():
            return "delivery", 3, message.step, message.time_ns, message.commanded
        case LinkRecord():
            return "lost", message.time_ns, message.number, message.departs_ns, message.arrives_ns
    return ()


def flight(name: str, log: Path | None = None) -> dict[str, object]:
    """Fly a shipped mission; return the hash of each of its streams, and its result. `log` keeps the flight."""
    streams = {kind: Digest() for kind in ("state", "observation", "action", "reward", "delivery", "lost")}

    def sink(message: Message) -> None:
        if numbers := _numbers(message):
            streams[numbers[0]].add(*numbers[1:])

    mission = load_mission(ROOT / "missions" / f"{name}.yaml")
    result = fly(mission, policy("ant-waypoint"), sink, log=log, pictures=log is not None)
    hashes: dict[str, object] = {kind: str(digest) for kind, digest in streams.items()}
    return hashes | {
        "outcome": result.outcome,
        "reached": result.waypoints_reached,
        "total": result.waypoints_total,
        "sim_time_ns": result.sim_time_ns,
    }


def evaluation(policy_name: str, suite_name: str, trials: int) -> dict[str, object]:
    """Evaluate a shipped policy on a shipped suite; return hashes of all steps, and what each case came to."""
    digest = Digest()
    with _every_step(lambda env, actions, step: digest.add(actions, env.batch.qpos, step.observation, step.terms)):
        result = evaluate(policy(policy_name), load_suite(suite_name), trials=trials, seed=1)
    digest.add(*([case.successes, case.falls, case.timeouts] for case in result.cases))
    return {"steps": str(digest), "successes": [case.successes for case in result.cases]}


def observations(name: str) -> str:
    """Hash what a layout makes of random states and goals."""
    robot, rng = load_robot("ant"), np.random.default_rng(7)
    qpos, qvel = rng.normal(size=(50, robot.model.nq)), rng.normal(size=(50, robot.model.nv))
    qpos[:, 3:7] /= np.linalg.norm(qpos[:, 3:7], axis=1, keepdims=True)
    view = SimulationView(
        robot=robot,
        body=body_of(qpos, qvel),
        qpos=qpos,
        goals=rng.normal(0, 6, size=(50, 2, 2)),
        noise=rng.uniform(-1, 1, size=(50, 4)),
        action=np.zeros((50, robot.num_actions)),
        steps=np.zeros(50, np.int64),
    )
    digest = Digest()
    digest.add(layout(name, robot).observe(view))
    return str(digest)


def batched(**config: Any) -> str:
    """Hash 300 steps of 16 robots under random actions."""
    env = BatchedWaypointEnv(TaskConfig(**config), 16, seed=5)
    digest, rng = Digest(), np.random.default_rng(11)
    digest.add(env.reset())
    for _ in range(300):
        step = env.step(rng.uniform(-1, 1, size=(16, env.robot.num_actions)))
        digest.add(step.observation, step.reward, step.terms, step.terminated, step.truncated, step.final_observation)
        digest.add(env.batch.qpos, env.batch.qvel)
    return str(digest)


def variations() -> dict[str, str]:
    """Hash the batched environment as the recipes can set it up."""
    varied = DomainRandomization(
        mass_factor=(0.8, 1.2),
        friction_factor=(0.5, 1.5),
        gravity_mps2=(8.0, 10.0),
        latency_s=(0.0, 0.02),
        sensor_noise=SensorNoise(joint_angle_rad=0.01, joint_speed_radps=0.1),
    )
    return {
        "plain": batched(),
        "legs": batched(course=Course(perimeter="legs", count=8, leg_m=(0.3, 2.0))),
        "ring": batched(observation="state_goal", course=Course(perimeter="ring", inner_radius_m=1.0)),
        "varied": batched(domain_randomization=varied),
        "retry": batched(
            course=Course(perimeter="legs", count=2, leg_m=(0.1, 1.0)), failure_replay=FailureReplay(probability=0.5)
        ),
    }


def training() -> dict[str, str]:
    """Hash the weights after two iterations of the flagship's recipe, cut short."""
    from waypointctl.training.algorithms.ppo_learner import PpoLearner  # torch is loaded by what needs it
    from waypointctl.training.state import TrainingState

    recipe_file = load_recipe(ROOT / "policies" / "ant-waypoint" / "train.yaml")
    ppo = recipe_file.recipe.algorithm.model_copy(update={"robots": 32, "rollout_steps": 16, "minibatch": 128})
    recipe = recipe_file.recipe.model_copy(update={"algorithm": ppo}).scaled_to(1024)
    state = TrainingState(replace(recipe_file, recipe=recipe), threads=1)
    learner = state.learner
    assert isinstance(learner, PpoLearner)
    state.enter_phase()
    for _ in range(2):
        learner.collect()
        learner.update()
    digest = Digest()
    for parameter in learner.ppo.policy.parameters():
        digest.add(parameter.detach().numpy())
    return {"ppo": str(digest)}


def policy(name: str) -> LoadedPolicy:
    return load_policy(ROOT / "policies" / name)


@contextmanager
def _every_step(seen: Callable[[BatchedWaypointEnv, NDArray[np.float64], Step], None]) -> Iterator[None]:
    step = BatchedWaypointEnv.step

    def watched(env: BatchedWaypointEnv, actions: NDArray[np.float64]) -> Step:
        done = step(env, actions)
        seen(env, actions, done)
        return done

    BatchedWaypointEnv.step = watched  # type: ignore[method-assign, assignment]
    try:
        yield
    finally:
        BatchedWaypointEnv.step = step  # type: ignore[method-assign]


EVALUATIONS: Final = {
    **{f"ant-waypoint {suite}": ("ant-waypoint", suite, 8) for suite in BUILT_IN},
    **{f"{name} paper": (name, "paper", 4) for name in POLICIES if name.startswith("policy")},
}


def all_of_it() -> dict[str, object]:
    return {
        "machine": machine(),
        "flights": {name: flight(name) for name in MISSIONS},
        "evaluations": {name: evaluation(*asked) for name, asked in EVALUATIONS.items()},
        "observations": {name: observations(name) for name in LAYOUTS},
        "batched": variations(),
        "training": training(),
    }


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    print(json.dumps(all_of_it(), indent=1, default=asdict))
