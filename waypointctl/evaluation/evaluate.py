"""Testing a policy on a suite of paths."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from typing import TypeAlias

import numpy as np

from waypointctl.errors import InputError, PolicyError
from waypointctl.evaluation.result import CaseResult, Evaluation
from waypointctl.evaluation.suite import Case, Suite
from waypointctl.evaluation.walk import Walks, walk
from waypointctl.evaluation.wilson import wilson_interval
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.require import require
from waypointctl.seeding import stream
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import TaskConfig

Progress: TypeAlias = Callable[[str, int], None]  # (the case's name, its trials that have ended)


def evaluate(
    policy: LoadedPolicy,
    suite: Suite,
    trials: int,
    seed: int,
    threads: int = 0,
    progress: Progress | None = None,
) -> Evaluation:
    """Walk each path of a suite `trials` times and count.

    Trial i of a case starts with the same posture whatever the other cases and however many trials there are.

    Args:
        policy: what is tested.
        suite: the paths.
        trials: of each case, > 0; they are walked side by side.
        seed: of the starts, not negative.
        threads: of the physics; 0 is one a core. The result does not depend on it.
        progress: called whenever trials have ended.

    Raises:
        PolicyError: it was made for a robot or an observation layout that there is not, or not any more.
    """
    env = _env(policy, suite, trials, seed, threads)
    results = []
    for case in suite.cases:
        name = f"evaluation/{suite.name}/{case.name}"
        env.starts = [stream(seed, name, trial) for trial in range(trials)]
        env.courses = [stream(seed, f"{name}/course", trial) for trial in range(trials)]
        ended = partial(progress, case.name) if progress else _ignore
        results.append(_summary(case, walk(env, policy, np.array(case.waypoints), ended)))
    return Evaluation(
        policy=policy.manifest.name,
        suite=suite.name,
        seed=seed,
        cases=tuple(results),
        acceptance=suite.acceptance,
        deadline=suite.deadline,
        policy_sha256=policy.sha256,
        versions={name: version(name) for name in ("waypointctl", "mujoco", "numpy", "onnxruntime")},
    )


def _env(policy: LoadedPolicy, suite: Suite, trials: int, seed: int, threads: int) -> BatchedWaypointEnv:
    config = TaskConfig(
        robot=policy.robot,
        observation=policy.observation_layout,
        acceptance=suite.acceptance.to_task(),
        deadline=suite.deadline.to_task(),
    )
    longest = max(len(case.waypoints) for case in suite.cases)
    try:
        env = BatchedWaypointEnv(config, trials, seed, threads=threads, max_waypoints=longest, autoreset=False)
    except InputError as error:
        raise PolicyError(error.problem, where=f"policy {policy.manifest.name!r}") from error
    require(
        policy,
        robot=env.robot.name,
        num_joints=env.robot.num_joints,
        components=env.layout.components,
        control_period_ns=env.robot.control_period_ns,
    )
    return env


def _summary(case: Case, walks: Walks) -> CaseResult:
    trials, successes = len(walks.success), int(walks.success.sum())
    return CaseResult(
        name=case.name,
        waypoints=case.waypoints,
        trials=trials,
        successes=successes,
        rate=successes / trials,
        wilson95=wilson_interval(successes, trials),
        falls=int(walks.fell.sum()),
        timeouts=int(walks.timed_out.sum()),
        mean_time_s=float(walks.time_s[walks.success].mean()) if successes else None,
        spl=walks.spl,
        paper=case.paper,
    )


def _ignore(ended: int) -> None:
    pass
