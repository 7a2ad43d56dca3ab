"""Static checks: what may go wrong in a mission, found without flying it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that a planner may want to change; the mission can be flown as it is.

    Attributes:
        kind: a word for programs, such as "fence".
        path: of what it is about, in the mission, by the fields' names.
        text: one line.
        prevents: whether a waypoint can never be reached, or never be known to be reached, because of it.
    """

    kind: str
    path: tuple[str | int, ...]
    text: str
    prevents: bool = False
