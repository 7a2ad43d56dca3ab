"""Flights, evaluations, observations, the environment and the learner come to the recorded numbers, bit for bit.

The hashes were recorded before the packages took their present shape. They hold on the processors and versions that
come to the same arithmetic as the machine that recorded them; elsewhere the results are compared and not the bits.
"""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from tests.golden import recording
from tests.shipped import shipped_flight


@cache
def golden() -> Any:
    return json.loads((Path(__file__).parent / "golden.json").read_text())


@cache
def same_arithmetic() -> bool:
    return bool(recording.machine() == golden()["machine"])


def check(found: Any, kind: str, name: str) -> None:
    expected = golden()[kind][name]
    if same_arithmetic():
        assert found == expected
        return
    if isinstance(expected, dict) and "outcome" in expected:
        assert found["outcome"] == expected["outcome"]
    pytest.skip("this processor or these versions come to other last bits than those that the hashes were recorded on")


@pytest.mark.parametrize("name", recording.MISSIONS)
def test_flights(name: str) -> None:
    check(shipped_flight(name)[0], "flights", name)


QUICK = ("ant-waypoint paper", "ant-waypoint region", "ant-waypoint station", "policy5 paper")


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[] if name in QUICK else pytest.mark.slow) for name in recording.EVALUATIONS],
)
def test_evaluations(name: str) -> None:
    check(recording.evaluation(*recording.EVALUATIONS[name]), "evaluations", name)


@pytest.mark.parametrize("name", recording.LAYOUTS)
def test_observations(name: str) -> None:
    check(recording.observations(name), "observations", name)


def test_batched_environment() -> None:
    found = recording.variations()
    assert found.keys() == golden()["batched"].keys()
    for name, digest in found.items():
        check(digest, "batched", name)


def test_training() -> None:
    check(recording.training()["ppo"], "training", "ppo")
