"""The colours of a picture, the same in each of its parts; told apart by the colour-blind (Okabe and Ito)."""

from __future__ import annotations

from typing import Final

from waypointctl.replay.story import Fate

ROBOT: Final = "#0072B2"
OPERATOR: Final = "#CC3D7A"
REACHED: Final = "#009E73"
FAILED: Final = "#D55E00"
UNPROVEN: Final = "#C00000"
OPEN: Final = "#8A8A8A"
INK: Final = "#222222"
FAINT: Final = "#B8B8B8"

FATES: Final = {Fate.REACHED: REACHED, Fate.TIMED_OUT: FAILED, Fate.SKIPPED: FAILED, Fate.OPEN: OPEN}
