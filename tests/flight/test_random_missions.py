"""Random missions end when all is over, their operators use what they know, and their logs prove them.

`python bench/random_missions.py --count 1000` flies many more.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from tests.budget import examples
from tests.flight.random_missions import judged
from waypointctl.policy.bundle import LoadedPolicy, load_policy

POLICY = Path(__file__).parents[2] / "policies" / "ant-waypoint"


@cache
def policy() -> LoadedPolicy:
    return load_policy(POLICY)


@pytest.mark.parametrize("seed", range(examples(64)))
def test_a_random_mission_has_no_fault(seed: int, tmp_path: Path) -> None:
    flight = judged(seed, policy(), tmp_path, proved=seed % 4 == 0)
    assert flight.faults == (), flight.result.reason
