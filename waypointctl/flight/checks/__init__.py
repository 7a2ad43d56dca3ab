"""Static checks: what may go wrong in a mission, found without flying it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that a planner may want to change; the mission can be flown as it is."""

    kind: str  # a word for programs, such as "fence"
    path: tuple[str | int, ...]  # of what it is about, in the mission, by the fields' names
    text: str  # one line
    prevents: bool = False  # whether a waypoint can never be reached, or never be known to be reached, because of it
