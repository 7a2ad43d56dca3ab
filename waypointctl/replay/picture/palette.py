"""What the colours of a flight's picture stand for, the same in each of its parts."""

from __future__ import annotations

from typing import Final

from waypointctl import figure
from waypointctl.replay.summary import WaypointStatus

ROBOT: Final = figure.BLUE
OPERATOR: Final = figure.PINK
REACHED: Final = figure.GREEN
FAILED: Final = figure.VERMILION
UNPROVEN: Final = figure.RED
HOME: Final = figure.OCHRE
KEEP_IN: Final = figure.GREEN
KEEP_OUT: Final = figure.RED
OPEN: Final = figure.GREY
INK: Final = figure.INK
FAINT: Final = figure.FAINT

FATES: Final = {
    WaypointStatus.REACHED: REACHED,
    WaypointStatus.TIMED_OUT: FAILED,
    WaypointStatus.SKIPPED: FAILED,
    WaypointStatus.OPEN: OPEN,
}
