"""Evaluating a policy on a suite of paths."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import TypeAlias

from waypointctl.errors import InputError, PolicyError, given_number, wrong_type
from waypointctl.evaluation.result import CaseResult, Evaluation, wilson_interval
from waypointctl.evaluation.rollout import Rollouts, rollout
from waypointctl.evaluation.suite import MOST_TRIALS, Case, RandomPaths, Suite, SuiteCase, load_suite
from waypointctl.flight.policy_fit import refuse_misfit
from waypointctl.mission.policy_name import policy_folder
from waypointctl.policy.bundle import LoadedPolicy, policy_of
from waypointctl.policy.protocol import Policy
from waypointctl.robots.load import given_robot, kept_robot
from waypointctl.robots.robot import Robot
from waypointctl.seeding import stream
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import TaskConfig
from waypointctl.task.plugins import Plugin, Plugins, load_plugins

Progress: TypeAlias = Callable[[str, int], None]  # (the case's name, its trials that have ended)
OnCase: TypeAlias = Callable[[SuiteCase, Rollouts], None]


def evaluate(
    policy: Policy | Path | str,
    suite: Suite | Path | str = "paper",
    trials: int | None = None,
    seed: int = 0,
    threads: int = 0,
    progress: Progress | None = None,
    on_case: OnCase | None = None,
    plugins: Plugins = (),
    robot: Robot | Path | str | None = None,
) -> Evaluation:
    """Run a policy many times on each path of a suite, with its actions as they are, and count how the trials ended.

    Trial i of a case has the same start, and the same path where paths are random, whatever the policy, the acceptance
    region, the other cases and the number of trials.

    Args:
        policy: itself, its folder, or its name.
        suite: itself, its file, or its name: "paper", "region", "anywhere", "station".
        trials: of each case, > 0, simulated in parallel; None: the suite's number.
        seed: of the starts and of random paths, not negative.
        threads: of the physics; 0 is one per core, 8 at most. The result does not depend on it.
        progress: called with a case's name and the number of its trials that have ended, whenever it grows.
        on_case: called with each case and the rollouts of its trials.
        plugins: observation groups that the policy was trained with and that are not built in: themselves, or the
            paths of their Python files, which are executed.
        robot: itself, its folder, or its name; None: the suite's, else that in the policy's folder, else the one that
            the policy names.

    Raises:
        PolicyError: the policy is missing, damaged, or made for another robot, observation layout or control period; or
            it observes a group that is neither built in nor in `plugins`.
        SuiteError: the suite does not exist, or the file is not a suite.
        RobotError: the robot does not exist, or its robot.yaml is wrong.
        InputError: an argument has a wrong type, the number of trials or the seed is invalid, or a plugin fails.
    """
    given, policy = policy, policy_of(policy)
    suite = load_suite(suite) if isinstance(suite, Path | str) else suite
    if not isinstance(suite, Suite):
        raise wrong_type("suite", suite, "a Suite, its file, or its name")
    trials = suite.trials if trials is None else given_number("trials", trials, 1, MOST_TRIALS)
    seed, threads = given_number("seed", seed, 0, 2**63 - 1), given_number("threads", threads, 0, 1024)
    if robot is None and isinstance(given, Path | str):
        robot = suite.robot or kept_robot(policy_folder(given) if isinstance(given, str) else given)
    plugins = load_plugins(plugins)
    env = _env(policy, suite, trials, seed, threads, plugins, robot or suite.robot or policy.robot)
    results = [_case_result(env, policy, suite, case, seed, progress, on_case) for case in suite.all_cases]
    return Evaluation(
        policy=policy.name,
        suite=suite.name,
        seed=seed,
        cases=tuple(results),
        acceptance=suite.acceptance,
        deadline=suite.deadline,
        policy_sha256=policy.sha256 if isinstance(policy, LoadedPolicy) else "",
        versions={name: version(name) for name in ("waypointctl", "mujoco", "numpy", "onnxruntime")},
        start=suite.start,
        hold=suite.hold,
        observation=env.layout.name,
    )


def _case_result(
    env: BatchedWaypointEnv,
    policy: Policy,
    suite: Suite,
    case: SuiteCase,
    seed: int,
    progress: Progress | None,
    on_case: OnCase | None,
) -> CaseResult:
    """Run the trials of one case."""
    trials, name = range(env.num_robots), f"evaluation/{suite.name}/{case.name}"
    env.starts = [stream(seed, name, trial) for trial in trials]
    env.courses = [stream(seed, f"{name}/course", trial) for trial in trials]
    paths = [case.trial_path(seed, f"{name}/path", trial, suite.start.position_m) for trial in trials]
    rollouts = rollout(env, policy, paths, partial(progress, case.name) if progress else _ignore, suite.hold)
    if on_case is not None:
        on_case(case, rollouts)
    return case_result(case, rollouts)


def case_result(case: SuiteCase, rollouts: Rollouts) -> CaseResult:
    """Return the counts and means of the trials of one case."""
    trials, successes = len(rollouts.success), int(rollouts.success.sum())
    legs_reached = int(rollouts.legs_reached.sum())
    time_s, path_m = rollouts.time_s[rollouts.success], rollouts.path_m[rollouts.success]
    return CaseResult(
        name=case.name,
        waypoints=case.path if isinstance(case, Case) else (),
        trials=trials,
        successes=successes,
        rate=successes / trials,
        wilson95=wilson_interval(successes, trials),
        falls=int(rollouts.fell.sum()),
        timeouts=int(rollouts.timed_out.sum()),
        mean_time_s=float(time_s.mean()) if successes else None,
        spl=rollouts.spl,
        paper=case.paper if isinstance(case, Case) else None,
        orbiting=int(rollouts.orbiting.sum()),
        stuck=int(rollouts.stuck.sum()),
        strayed=int(rollouts.strayed.sum()),
        # A trial that ends before a waypoint has started that leg, and none after it.
        legs=legs_reached + int((rollouts.legs_reached < rollouts.legs).sum()),
        legs_reached=legs_reached,
        mean_leg_time_s=float(rollouts.legs_time_s.sum()) / legs_reached if legs_reached else None,
        mean_speed_mps=float(path_m.sum() / time_s.sum()) if successes else None,
        course=case if isinstance(case, RandomPaths) else None,
    )


def _env(
    policy: Policy,
    suite: Suite,
    trials: int,
    seed: int,
    threads: int,
    plugins: tuple[Plugin, ...],
    named: Robot | Path | str,
) -> BatchedWaypointEnv:
    try:
        robot = given_robot(named)
    except InputError as error:
        if error.where is not None or named != policy.robot:
            raise
        raise PolicyError(error.problem, where=f"policy {policy.name!r}", hint=error.hint) from error
    refuse_misfit(policy, robot, plugins)
    config = TaskConfig(
        robot=robot,
        observation=policy.observation_layout,
        acceptance=suite.acceptance,
        deadline=suite.deadline,
        start=suite.start,
        plugins=plugins,
    )
    longest = max(case.longest for case in suite.all_cases)
    return BatchedWaypointEnv(config, trials, seed, threads=threads, max_waypoints=longest, autoreset=False)


def _ignore(ended: int) -> None:
    pass
