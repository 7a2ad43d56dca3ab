from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from tests.task.views import ant_layout
from waypointctl.errors import PolicyError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import ActionSpec
from waypointctl.policy.require import require

COMPONENTS = ant_layout("egocentric").components


@pytest.fixture(scope="module")
def policy(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> LoadedPolicy:
    folder: Path = tmp_path_factory.mktemp("policies") / "tiny"
    return make_policy(folder)


def check(
    policy: LoadedPolicy,
    *,
    robot: str = "ant",
    num_joints: int = 8,
    components: Sequence[tuple[str, str, float]] = COMPONENTS,
    control_period_ns: int = 20_000_000,
) -> None:
    require(policy, robot=robot, num_joints=num_joints, components=components, control_period_ns=control_period_ns)


def test_a_policy_that_fits_passes(policy: LoadedPolicy) -> None:
    check(policy)


def test_another_robot_is_refused(policy: LoadedPolicy) -> None:
    with pytest.raises(PolicyError, match=r"policy 'tiny': made for the robot 'ant', not 'rover'\n  Choose a policy"):
        check(policy, robot="rover")


def test_a_layout_of_another_size_is_refused(policy: LoadedPolicy) -> None:
    with pytest.raises(PolicyError, match="another observation layout 'egocentric': it has 31 numbers, not 29"):
        check(policy, components=ant_layout("state_goal").components)


def test_a_layout_in_another_order_is_refused(policy: LoadedPolicy) -> None:
    swapped = (COMPONENTS[1], COMPONENTS[0], *COMPONENTS[2:])
    with pytest.raises(PolicyError, match=r": number 0 is 'current\.ahead', not 'current\.left'"):
        check(policy, components=swapped)


@pytest.mark.parametrize(
    ("component", "message"),
    [
        (("current.distance", "km", 0.2), ": unit of number 2 is 'm', not 'km'"),
        (("current.distance", "m", 0.1), r": scale of number 2 is 0\.2, not 0\.1"),
    ],
)
def test_a_layout_that_means_other_quantities_by_the_same_names_is_refused(
    policy: LoadedPolicy, component: tuple[str, str, float], message: str
) -> None:
    with pytest.raises(PolicyError, match=message):
        check(policy, components=(*COMPONENTS[:2], component, *COMPONENTS[3:]))


def test_another_number_of_joints_is_refused(policy: LoadedPolicy) -> None:
    with pytest.raises(PolicyError, match="made for other actions: it has 8, and the robot has 12 joints"):
        check(policy, num_joints=12)


def test_other_limits_of_the_actions_are_refused(tmp_path: Path, make_policy: Callable[..., LoadedPolicy]) -> None:
    strong = ActionSpec(size=8, meaning="torque", limits=(-150.0, 150.0))
    with pytest.raises(
        PolicyError, match=r"actions: within \[-150\.0, 150\.0\], not \[-1\.0, 1\.0\]\n  Train a policy"
    ):
        check(make_policy(tmp_path / "strong", action=strong))


def test_another_control_period_is_refused(policy: LoadedPolicy) -> None:
    with pytest.raises(PolicyError, match=r"control period of 20 ms, not 16\.5 ms"):
        check(policy, control_period_ns=16_500_000)
