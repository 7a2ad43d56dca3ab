"""What may go wrong in a mission, and where its file says so."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

NOT_COMPLETED: Final = "will not be completed"  # a leg


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that a planner may want to change; the mission can be flown as it is.

    Attributes:
        kind: a word for programs, such as "fence".
        path: of what it is about, in the mission, by the fields' names.
        text: one line.
        consequence: None where the mission can succeed all the same. Else the mission may fail by it, and this is added
            to the text where it is expected to; empty if the text says so itself.
    """

    kind: str
    path: tuple[str | int, ...]
    text: str
    consequence: str | None = None
