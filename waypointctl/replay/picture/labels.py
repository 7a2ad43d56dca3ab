"""Labels that cover no other label: each goes to the first of its places where there is room, or is left out."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Bbox, IdentityTransform

from waypointctl.display_text import printable
from waypointctl.figure import BLUE, GREEN, GREY, OCHRE, PINK, RED, VERMILION
from waypointctl.replay.legs import WaypointStatus
from waypointctl.replay.track import FloatArray

SIZE_PT: Final = 8
_CLEARANCE_PX: Final = 2.0
_SHARES: Final = {"left": 0.0, "bottom": 0.0, "center": 0.5, "right": 1.0, "top": 1.0}


@dataclass(frozen=True, slots=True)
class Place:
    """Where a label may stand: its corner or the middle of a side, in pixels, and how it lies there."""

    x_px: float
    y_px: float
    horizontal: str = "left"  # "left", "center" or "right": where of the text x_px is
    vertical: str = "bottom"  # "bottom", "center" or "top"

    def box(self, width_px: float, height_px: float) -> Bbox:
        """Return what a label of this size covers here."""
        left, bottom = self.x_px - _SHARES[self.horizontal] * width_px, self.y_px - _SHARES[self.vertical] * height_px
        return Bbox.from_bounds(left, bottom, width_px, height_px)


class Labels:
    """The labels of one part of a picture, whose limits are set by now."""

    def __init__(self, axes: Axes, avoided: FloatArray | None = None) -> None:
        """Label `axes`; where there is a choice, cover few of the points `avoided` (n, 2) [pixels]."""
        self._axes = axes
        self._avoided = np.zeros((0, 2)) if avoided is None else avoided
        self._room = axes.get_window_extent().padded(4 * _CLEARANCE_PX)
        self._taken = np.zeros((0, 4))  # left, bottom, right, top of each label that is written
        self.left_out = 0

    def pixels(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of the axes is in the picture [pixels]."""
        x_px, y_px = self._axes.transData.transform((x, y))
        return float(x_px), float(y_px)

    def put(
        self, text: str, places: Iterable[Place], color: str, *, size_pt: float = SIZE_PT, rotation: float = 0.0
    ) -> bool:
        """Write a text at the best of some places; return whether there was room."""
        label = self._axes.text(
            0.0,
            0.0,
            text,
            va="bottom",
            transform=IdentityTransform(),
            fontsize=size_pt,
            color=color,
            rotation=rotation,
            zorder=6,
            path_effects=[withStroke(linewidth=2.5, foreground="white")],
        )
        size = label.get_window_extent()
        boxes = [(place, place.box(size.width, size.height).padded(_CLEARANCE_PX)) for place in places]
        free = [(place, box) for place, box in boxes if self._is_free(box)]
        if not free:
            label.remove()
            self.left_out += 1
            return False
        best, box = min(free, key=lambda one: self._covered(one[1]))
        label.set(position=(best.x_px, best.y_px), ha=best.horizontal, va=best.vertical)
        self._taken = np.vstack([self._taken, box.extents])
        return True

    def _is_free(self, box: Bbox) -> bool:
        room, (left, bottom, right, top) = self._room, box.extents
        inside = room.x0 <= left and right <= room.x1 and room.y0 <= bottom and top <= room.y1
        beside = (self._taken[:, :2] >= (right, top)) | (self._taken[:, 2:] <= (left, bottom))
        return inside and bool(beside.any(axis=1).all())

    def _covered(self, box: Bbox) -> int:
        x, y = self._avoided.T
        return int(np.count_nonzero((x >= box.x0) & (x <= box.x1) & (y >= box.y0) & (y <= box.y1)))


def around(left: float, right: float, bottom: float, top: float) -> Sequence[Place]:
    """Return the places beside, above and below a region [pixels], the best known ones first."""
    gap, middle, center = 3.0, (left + right) / 2, (bottom + top) / 2
    return (
        Place(right + gap, top + gap),
        Place(right + gap, center, vertical="center"),
        Place(right + gap, bottom - gap, vertical="top"),
        Place(left - gap, top + gap, horizontal="right"),
        Place(left - gap, center, "right", "center"),
        Place(left - gap, bottom - gap, "right", "top"),
        Place(middle, top + gap, horizontal="center"),
        Place(middle, bottom - gap, "center", "top"),
    )


def short(name: str, most: int) -> str:
    """Return a name fit to show in at most `most` characters: the end of a longer one is left out."""
    shown = printable(name, len(name))
    return shown if len(shown) <= most else f"{shown[: most - 1].rstrip()}\N{HORIZONTAL ELLIPSIS}"


ROBOT: Final = BLUE
OPERATOR: Final = PINK
REACHED: Final = GREEN
FAILED: Final = VERMILION
UNPROVEN: Final = RED
HOME: Final = OCHRE
KEEP_IN: Final = GREEN
KEEP_OUT: Final = RED
OPEN: Final = GREY

STATUS_COLORS: Final = {
    WaypointStatus.REACHED: REACHED,
    WaypointStatus.TIMED_OUT: FAILED,
    WaypointStatus.SKIPPED: FAILED,
    WaypointStatus.OPEN: OPEN,
}
