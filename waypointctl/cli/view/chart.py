"""The map: waypoints with their acceptance, the way walked, the robot, and where the operator believes it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.cli.view.canvas import CELL_HEIGHT, CELL_WIDTH, Canvas
from waypointctl.display_text import printable
from waypointctl.replay.story import Fate, WaypointStory, is_on_map

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.text import Text

FloatArray = NDArray[np.float64]

WAY: Final = "cyan"
ROBOT: Final = "bold green"
BELIEF: Final = "bold magenta"
_FATE_STYLES: Final = {
    Fate.REACHED: "green",
    Fate.TIMED_OUT: "red",
    Fate.SKIPPED: "red",
    Fate.OPEN: "yellow",
}
_MARGIN: Final = 0.04  # of the larger side, around everything
_SMALLEST_M: Final = 2.0  # a map is never of less than this


@dataclass(frozen=True, slots=True)
class Scene:
    """What a map shows.

    Attributes:
        x_m: the way walked, (n,); the robot is at its end.
        y_m: likewise.
        waypoints: of the mission.
        belief: where the operator believes the robot to be, None before it has heard of it.
    """

    x_m: FloatArray
    y_m: FloatArray
    waypoints: Sequence[WaypointStory]
    belief: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class _Frame:
    """From metres to dots, the same scale along both axes."""

    left_m: float
    top_m: float
    dots_per_m: float

    def dots(self, x_m: FloatArray, y_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        return (x_m - self.left_m) * self.dots_per_m, (self.top_m - y_m) * self.dots_per_m

    def dot(self, x_m: float, y_m: float) -> tuple[float, float]:
        return (x_m - self.left_m) * self.dots_per_m, (self.top_m - y_m) * self.dots_per_m


def draw_map(scene: Scene, columns: int, lines: int, *, ascii_only: bool = False) -> list[Text]:
    """Return the map in `lines` lines of `columns` characters; the last line has the scale and the signs.

    Waypoints and a belief that an altered log put nowhere, or farther than any map reaches, are left out.
    """
    waypoints = [waypoint for waypoint in scene.waypoints if waypoint.is_on_map]
    belief = scene.belief if scene.belief is not None and is_on_map(*scene.belief) else None
    scene = replace(scene, waypoints=waypoints, belief=belief)
    canvas = Canvas(columns, lines - 1)
    frame = _frame(scene, canvas)
    for waypoint in scene.waypoints:
        canvas.polyline(*frame.dots(*_region(waypoint)), _FATE_STYLES[waypoint.fate])
    canvas.polyline(*frame.dots(scene.x_m, scene.y_m), WAY)
    if len(scene.x_m):
        canvas.sign(*frame.dot(float(scene.x_m[0]), float(scene.y_m[0])), "+", WAY)
    if scene.belief is not None:
        canvas.sign(*frame.dot(*scene.belief), "o" if ascii_only else "◇", BELIEF)
    if len(scene.x_m):
        canvas.sign(*frame.dot(float(scene.x_m[-1]), float(scene.y_m[-1])), "@" if ascii_only else "●", ROBOT)
    for waypoint in scene.waypoints:
        _label(canvas, frame, waypoint)
    return [*canvas.rows(ascii_only=ascii_only), _legend(frame, columns, ascii_only)]


def _region(waypoint: WaypointStory) -> tuple[FloatArray, FloatArray]:
    """Return the outline of the acceptance, x (n,) and y (n,) [m]."""
    plan = waypoint.planned
    if plan.acceptance == "box":
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * plan.tolerance_m
    else:
        turn = np.linspace(0.0, 2.0 * math.pi, 33)
        corners = np.column_stack([np.cos(turn), np.sin(turn)]) * plan.tolerance_m
    return plan.x_m + corners[:, 0], plan.y_m + corners[:, 1]


def _frame(scene: Scene, canvas: Canvas) -> _Frame:
    outlines = [_region(waypoint) for waypoint in scene.waypoints]
    x_m = np.concatenate([scene.x_m, *(outline[0] for outline in outlines)])
    y_m = np.concatenate([scene.y_m, *(outline[1] for outline in outlines)])
    if not len(x_m):
        x_m = y_m = np.zeros(1)
    wide, high = np.ptp(x_m), np.ptp(y_m)
    margin = max(wide, high) * _MARGIN
    wide, high = max(wide + 2 * margin, _SMALLEST_M), max(high + 2 * margin, _SMALLEST_M)
    scale = min(canvas.width / wide, canvas.height / high)
    center_x, center_y = (x_m.min() + x_m.max()) / 2, (y_m.min() + y_m.max()) / 2
    return _Frame(center_x - canvas.width / scale / 2, center_y + canvas.height / scale / 2, scale)


def _label(canvas: Canvas, frame: _Frame, waypoint: WaypointStory) -> None:
    """Write the waypoint's name beside its region, on whichever side there is room."""
    plan = waypoint.planned
    x, y = frame.dot(plan.x_m, plan.y_m)
    reach = plan.tolerance_m * frame.dots_per_m
    name = printable(plan.name)
    length = len(name)
    right, left = x + reach + CELL_WIDTH, x - reach - CELL_WIDTH * (length + 1)
    middle = x - CELL_WIDTH * (length // 2)
    places = ((right, y), (left, y), (middle, y - reach - CELL_HEIGHT), (middle, y + reach + CELL_HEIGHT))
    for place in places:
        if canvas.is_free(*place, length):
            canvas.sign(*place, name, _FATE_STYLES[waypoint.fate])
            return


def _legend(frame: _Frame, columns: int, ascii_only: bool) -> Text:
    from rich.text import Text

    legend = Text(no_wrap=True, overflow="crop")
    length_m = _round_length(columns / 5 * CELL_WIDTH / frame.dots_per_m)
    cells = max(2, round(length_m * frame.dots_per_m / CELL_WIDTH))
    legend.append("|" + "-" * (cells - 2) + "|" if ascii_only else "├" + "─" * (cells - 2) + "┤", "dim")
    legend.append(f" {length_m:g} m", "dim")
    for sign, plain, style, text in (("●", "@", ROBOT, "robot"), ("◇", "o", BELIEF, "operator's belief")):
        legend.append("  ").append(plain if ascii_only else sign, style).append(f" {text}", "dim")
    legend.truncate(columns)
    return legend


def _round_length(length_m: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not above `length_m`."""
    power = 10.0 ** math.floor(math.log10(length_m))
    return next(step * power for step in (5, 2, 1) if step * power <= length_m * (1 + 1e-9))
