"""What a mission asks for that can never be, whatever happens on the way: known once all of its parts are."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from pydantic import ValidationError
from pydantic_core import InitErrorDetails

from waypointctl.mission.checks import error_at

if TYPE_CHECKING:
    from waypointctl.mission.mission import Mission


def possible(mission: Mission) -> None:
    """Check that no waypoints are released, and no commands cancelled, that there can never be.

    Raises:
        ValidationError: some are, each of them named.
    """
    if errors := [*_released(mission), *_cancelled(mission)]:
        raise ValidationError.from_exception_data("mission", errors)


def _released(mission: Mission) -> Iterator[InitErrorDetails]:
    """Yield what releases more waypoints than there are; no command makes the plan longer."""
    count = mission.num_legs
    given: list[tuple[tuple[str | int, ...], int]] = [(("operator", "released"), mission.operator.released)]
    given += [(("schedule", place, "released"), each.released or 0) for place, each in enumerate(mission.schedule)]
    for loc, released in given:
        if released > count:
            plan = f"{count} waypoint{'s' * (count > 1)} of the plan"
            yield error_at(f"{released} is more than the {plan}; write -1 to release them all", loc, released)


def _cancelled(mission: Mission) -> Iterator[InitErrorDetails]:
    """Yield what cancels a command that cannot have been sent by then: each gets its number when it is sent."""
    own = _most_own_commands(mission)
    if own is None:
        return
    in_turn = sorted(range(len(mission.schedule)), key=lambda place: mission.schedule[place].at_s)
    for earlier, place in enumerate(in_turn):
        command = mission.schedule[place].command
        if command is not None and command > own + earlier:
            sent = f"at most {own + earlier} {'is' if own + earlier == 1 else 'are'} sent before this one"
            problem = (
                f"no command {command} can have been sent by then: under autonomy {mission.autonomy} {sent} (they "
                "count from 1, in the order of sending)"
            )
            yield error_at(problem, ("schedule", place, "command"), command)


def _most_own_commands(mission: Mission) -> int | None:
    """Return how many commands the operator sends at most, beside the schedule; None where nobody can know."""
    if mission.autonomy == "short_range_goal":
        return None
    if mission.autonomy == "mission":
        return 1
    # One a waypoint; a pilot's last command may be to hold once time is out.
    return mission.num_legs + (mission.autonomy == "joint")
