"""A plan of which a part is never released: the robot waits for it, and the operator for the end."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.flight.forecast.finding import Finding
from waypointctl.mission.mission import Mission

# Commands after which a plan is over, or shorter, without being released.
_ENDS_A_PLAN: Final = ("go_to", "return_home", "abort", "cancel", "skip")


def waits_for_ever(mission: Mission) -> bool:
    """Tell whether a plan that is sent at once is never released to its end."""
    if any(command.do in _ENDS_A_PLAN for command in mission.schedule):
        return False
    return _most_released(mission) < mission.num_legs


def release_findings(mission: Mission) -> Iterator[Finding]:
    """Yield a plan of which a part is never released."""
    if mission.autonomy == "mission" and waits_for_ever(mission):
        text = (
            f"{_most_released(mission)} of {mission.num_legs} waypoints are released, and nothing in the schedule "
            "releases more: the robot waits for the rest, and the mission never ends"
        )
        yield Finding("release", ("operator", "released"), text, consequence="")


def _most_released(mission: Mission) -> int:
    """Return how many waypoints are released in the end, at the start or by the schedule."""
    given = (mission.operator.released, *(command.released for command in mission.schedule))
    return max(mission.num_legs if released < 0 else released for released in given if released is not None)
