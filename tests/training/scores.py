"""Tests of checkpoints whose outcome is written down beforehand, by the step of the checkpoint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from waypointctl.evaluation.evaluate import evaluate
from waypointctl.evaluation.result import Evaluation
from waypointctl.evaluation.suite import Suite
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.training import evaluator

SELECTING = "selection: {suite: near.yaml, trials: 2, seed: 50, every: 300}\n"
NEAR = "name: near\ndeadline: {first_s: 0.1, further_s: 0}\ncases: [{name: ahead, waypoints: [[3, 0]]}]\n"


def scripted(patch: pytest.MonkeyPatch, scores: Mapping[int, float]) -> list[int]:
    """Let the suite `near` come out as `scores` say, by steps; return the list of steps that were tested."""
    tested: list[int] = []

    def scored(policy: LoadedPolicy, suite: Suite, trials: int, seed: int, *more: Any, **named: Any) -> Evaluation:
        found = evaluate(policy, suite, trials, seed, *more, **named)
        if suite.name != "near":
            return found
        assert (trials, seed) == (2, 50)
        steps = policy.manifest.training.steps
        tested.append(steps)
        successes = round(scores[steps] * trials)
        case = found.cases[0].model_copy(update={"successes": successes, "falls": trials - successes})
        return found.model_copy(update={"cases": (case,)})

    patch.setattr(evaluator, "evaluate", scored)
    return tested
