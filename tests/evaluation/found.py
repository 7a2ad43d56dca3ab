"""Evaluations to show, without evaluating anything."""

from __future__ import annotations

from waypointctl.evaluation.result import CaseResult, Evaluation, wilson_interval
from waypointctl.evaluation.suite import Training, load_suite


def case_result(name: str, waypoints: tuple[tuple[float, float], ...] = ((6.0, 6.0),), **changes: object) -> CaseResult:
    """Return 9 successes in 10 trials, one of which fell, but for `changes`."""
    result = CaseResult(
        name=name,
        waypoints=waypoints,
        trials=10,
        successes=9,
        rate=0.9,
        wilson95=wilson_interval(9, 10),
        falls=1,
        timeouts=0,
        mean_time_s=5.0,
        spl=0.8,
        paper=None,
        orbiting=0,
        stuck=0,
        strayed=0,
    )
    return result.model_copy(update=changes)


def paper_evaluation(policy: str, training: Training | None, observation: str, successes: int) -> Evaluation:
    """Return an evaluation on the paper's suite, with as many successes of 10 in each case; the others fell."""
    suite = load_suite("paper")
    changes = {
        "successes": successes,
        "rate": successes / 10,
        "wilson95": wilson_interval(successes, 10),
        "falls": 10 - successes,
    }
    return Evaluation(
        policy=policy,
        suite="paper",
        seed=1,
        cases=tuple(case_result(case.name, case.path, paper=case.paper, **changes) for case in suite.cases),
        acceptance=suite.acceptance,
        deadline=suite.deadline,
        policy_sha256=f"{successes:x}" * 64,
        versions={},
        training=training,
        observation=observation,
    )
