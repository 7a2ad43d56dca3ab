"""Refusing a policy that was made for something else."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from waypointctl.errors import PolicyError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import ActionSpec, Manifest, ObservationSpec
from waypointctl.policy.protocol import Policy
from waypointctl.units import NS_PER_S

LIMITS: Final = (-1.0, 1.0)  # of an action
_NS_PER_MS: Final = NS_PER_S // 1000


def require(
    policy: LoadedPolicy,
    *,
    robot: str,
    num_joints: int,
    components: Sequence[tuple[str, str, float]],
    control_period_ns: int,
) -> None:
    """Refuse a policy that was not made for this robot, these observations and this control period.

    Args:
        policy: the policy that is to act.
        robot: the robot's name.
        num_joints: how many motors the robot has, each of which takes an action in [-1, 1].
        components: (name, unit, scale) of each number of the observation, in order.
        control_period_ns: from one action to the next [ns].

    Raises:
        PolicyError: it was made for another robot, observation layout, control period or kind of action.
    """
    refuse_other_robot(policy, robot)
    made_for = policy.manifest
    where = f"policy {made_for.name!r}"
    if fault := _layout_fault(made_for.observation, components):
        problem = f"made for another observation layout {made_for.observation.layout!r}: {fault}"
        raise PolicyError(problem, where=where, hint="train a policy with this version of the layout")
    if fault := _action_fault(made_for.action, num_joints):
        raise PolicyError(
            f"made for other actions: {fault}", where=where, hint=f"train a policy for {robot!r} as it is"
        )
    if made_for.control_period_ns != control_period_ns:
        problem = f"made for a control period of {_ms(made_for.control_period_ns)}, not {_ms(control_period_ns)}"
        raise PolicyError(problem, where=where, hint="use a policy trained at the robot's control period")


def refuse_other_robot(policy: Policy | Manifest, robot: str) -> None:
    """Refuse a policy that was made for another robot.

    Raises:
        PolicyError: it was.
    """
    if policy.robot != robot:
        problem = f"made for the robot {policy.robot!r}, not {robot!r}"
        hint = f"choose a policy for {robot!r}: `waypointctl policies` lists them"
        raise PolicyError(problem, where=f"policy {policy.name!r}", hint=hint)


def _layout_fault(made_for: ObservationSpec, given: Sequence[tuple[str, str, float]]) -> str:
    if made_for.size != len(given):
        return f"it has {made_for.size} numbers, not {len(given)}"
    expected = zip(made_for.names, made_for.units, made_for.scales, strict=True)
    for index, (expected_number, found_number) in enumerate(zip(expected, given, strict=True)):
        for what, of, there in zip(("", "unit of ", "scale of "), expected_number, found_number, strict=True):
            if of != there:
                return f"{what}number {index} is {of!r}, not {there!r}"
    return ""


def _action_fault(made_for: ActionSpec, num_joints: int) -> str:
    if made_for.size != num_joints:
        return f"it has {made_for.size}, and the robot has {num_joints} joints"
    if made_for.limits != LIMITS:
        return f"within {list(made_for.limits)}, not {list(LIMITS)}"
    return ""


def _ms(time_ns: int) -> str:
    return f"{time_ns / _NS_PER_MS:g} ms"
