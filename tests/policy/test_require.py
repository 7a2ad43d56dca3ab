from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from waypointctl.errors import PolicyError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.require import require
from waypointctl.task.observation import layout

NAMES = [name for name, _, _ in layout("egocentric").components]


@pytest.fixture(scope="module")
def policy(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> LoadedPolicy:
    folder: Path = tmp_path_factory.mktemp("policies") / "tiny"
    return make_policy(folder)


def test_a_policy_that_fits_passes(policy: LoadedPolicy) -> None:
    require(policy, robot="ant", layout_names=NAMES, control_period_ns=20_000_000)


def test_another_robot_is_refused(policy: LoadedPolicy) -> None:
    with pytest.raises(PolicyError, match=r"policy 'tiny': made for the robot 'ant', not 'rover'\n  choose a policy"):
        require(policy, robot="rover", layout_names=NAMES, control_period_ns=20_000_000)


def test_a_layout_of_another_size_is_refused(policy: LoadedPolicy) -> None:
    names = [name for name, _, _ in layout("state_goal").components]
    with pytest.raises(PolicyError, match="another observation layout 'egocentric': it has 31 numbers, not 29"):
        require(policy, robot="ant", layout_names=names, control_period_ns=20_000_000)


def test_a_layout_in_another_order_is_refused(policy: LoadedPolicy) -> None:
    swapped = [NAMES[1], NAMES[0], *NAMES[2:]]
    with pytest.raises(PolicyError, match=r"number 0 is 'current\.ahead', not 'current\.left'"):
        require(policy, robot="ant", layout_names=swapped, control_period_ns=20_000_000)


def test_another_control_period_is_refused(policy: LoadedPolicy) -> None:
    with pytest.raises(PolicyError, match=r"control period of 20 ms, not 16\.5 ms"):
        require(policy, robot="ant", layout_names=NAMES, control_period_ns=16_500_000)
