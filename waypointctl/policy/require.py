"""Refusing a policy that was made for something else."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from waypointctl.errors import PolicyError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.units import NS_PER_S

_NS_PER_MS: Final = NS_PER_S // 1000


def require(policy: LoadedPolicy, *, robot: str, layout_names: Sequence[str], control_period_ns: int) -> None:
    """Refuse a policy that was not made for this robot, these observations and this control period.

    Args:
        policy: the policy that is to act.
        robot: the robot's name.
        layout_names: (k,) what each number of the observation is, in order.
        control_period_ns: from one action to the next [ns].

    Raises:
        PolicyError: it was made for another robot, observation layout or control period.
    """
    made_for = policy.manifest
    where = f"policy {made_for.name!r}"
    if made_for.robot != robot:
        problem = f"made for the robot {made_for.robot!r}, not {robot!r}"
        raise PolicyError(
            problem, where=where, mend=f"choose a policy for {robot!r}: `waypointctl policies` lists them"
        )
    if fault := _layout_fault(made_for.observation.names, layout_names):
        problem = f"made for another observation layout {made_for.observation.layout!r}: {fault}"
        raise PolicyError(problem, where=where, mend="train a policy with this version of the layout")
    if made_for.control_period_ns != control_period_ns:
        problem = f"made for a control period of {_ms(made_for.control_period_ns)}, not {_ms(control_period_ns)}"
        raise PolicyError(problem, where=where, mend="use a policy trained at the robot's control period")


def _layout_fault(made_for: Sequence[str], given: Sequence[str]) -> str:
    if len(made_for) != len(given):
        return f"it has {len(made_for)} numbers, not {len(given)}"
    for index, (expected, found) in enumerate(zip(made_for, given, strict=True)):
        if expected != found:
            return f"number {index} is {expected!r}, not {found!r}"
    return ""


def _ms(time_ns: int) -> str:
    return f"{time_ns / _NS_PER_MS:g} ms"
