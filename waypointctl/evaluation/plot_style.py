"""How the picture of evaluations shows ways and regions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from waypointctl.evaluation.conditions import Hold
from waypointctl.evaluation.panels import End
from waypointctl.figure import BLUE, INK, OCHRE, PURPLE, VERMILION
from waypointctl.mission.fields import Acceptance

# The colour of a way, and the mark at its end.
LOOKS: Final[dict[End, tuple[str, str]]] = {
    "success": (BLUE, ""),
    "fall": (VERMILION, "x"),
    "time-out": (PURPLE, "s"),
    "strayed": (OCHRE, "D"),
}
HOLD: Final[dict[str, Any]] = {"facecolor": "none", "edgecolor": INK, "linestyle": ":", "linewidth": 0.8, "zorder": 2}


@dataclass(frozen=True, slots=True)
class Regions:
    """What is drawn around waypoints.

    Attributes:
        acceptance: around each.
        hold: around the last one, where it is to be held.
    """

    acceptance: Acceptance
    hold: Hold | None
