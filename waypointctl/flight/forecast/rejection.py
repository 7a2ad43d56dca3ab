"""What follows when the robot rejects a waypoint that lies outside its fence."""

from __future__ import annotations

from typing import Final

from waypointctl.mission.mission import Mission

_FOLLOWS: Final = {
    "mission": "the robot will reject the whole plan, and stand where it starts",
    "waypoint": "the robot will reject it, and the mission ends there",
    "heading": "the robot will reject the first goal outside, and the mission ends there",
    "joint": "the robot stops at the fence, by its rule, and the pilot goes on in vain",
}


def rejection(mission: Mission) -> str:
    """Return what follows from a waypoint outside the fence, under the mission's autonomy."""
    return _FOLLOWS[mission.autonomy]
