"""Shipped missions, mutated at random, are read or refused with a place; bench/mutated_missions.py tries thousands."""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path

import pytest

from tests.budget import examples
from tests.mission.mutations import MUTATIONS, mutated
from waypointctl.mission.files import beside, examine_mission

MISSIONS = sorted((Path(__file__).parents[2] / "missions").glob("*.yaml"))


@pytest.mark.parametrize("seed", range(examples(40)))
def test_a_mutated_mission_is_read_or_refused_with_a_place(tmp_path: Path, seed: int) -> None:
    outcomes: Counter[bool] = Counter()
    for index in range(20):
        rng = random.Random(f"{seed}-{index}")
        source = mutated(rng.choice(MISSIONS).read_bytes(), rng)
        reading = examine_mission(source, "m.yaml", beside(tmp_path / "m.yaml"))
        outcomes[reading.model is not None] += 1
        assert (reading.model is None) == bool(reading.problems)
        assert all(problem.line > 0 and problem.column > 0 for problem in reading.problems)
        assert all(str(problem).isprintable() for problem in reading.problems)
    assert outcomes[False]


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda each: each.__name__)
def test_each_mutation_alters_a_mission(mutation: object) -> None:
    assert callable(mutation)
    source = MISSIONS[0].read_bytes()
    altered = [mutation(source, random.Random(seed)) for seed in range(20)]
    assert sum(each != source for each in altered) >= 10
