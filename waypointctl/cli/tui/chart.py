"""The map: zones, waypoints with their acceptance, the path, home, the robot, and its last known position."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, TypeVar

import numpy as np
from rich.cells import cell_len
from rich.text import Text

from waypointctl.cli.tui.canvas import CELL_HEIGHT, CELL_WIDTH, Canvas
from waypointctl.cli.tui.formatting import shortened
from waypointctl.log.header import MissionSetting
from waypointctl.mission.onboard import Zone
from waypointctl.replay.legs import ReturnHome, WaypointStatus, WaypointSummary
from waypointctl.replay.summary import FlightSummary
from waypointctl.replay.summary_builder import FlightSummaryBuilder
from waypointctl.replay.track import FloatArray, IntArray, Track, extent, is_on_map

Metres = TypeVar("Metres", float, FloatArray)


@dataclass(frozen=True, slots=True)
class Scene:
    """What a map shows."""

    truth: Track  # the path driven; the robot is at its end
    waypoints: Sequence[WaypointSummary]  # of the mission
    # where the operator believes the robot to be, None before the first telemetry
    belief: tuple[float, float] | None = None
    setting: MissionSetting = field(default_factory=MissionSetting)  # home, zones and contact windows
    returns: Sequence[ReturnHome] = ()  # the ways home
    # when each message was sent that did not arrive, (n,)
    missing_ns: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def home(self) -> tuple[float, float] | None:
        """Where home is, where that matters."""
        home = self.setting.home_to_show(has_returned=bool(self.returns))
        return None if home is None else (home.x_m, home.y_m)


def scene_so_far(flight: FlightSummaryBuilder, most: int) -> Scene:
    """Return what a map shows of a flight under way, the way in about `most` points."""
    frame, link = flight.telemetry, flight.link.summary(flight.now_ns)
    believed = None if frame is None else (frame.x_m, frame.y_m)
    truth, returns = flight.truth(most), flight.returns
    return Scene(truth, flight.waypoints, believed, flight.setting, returns, link.missing_ns)


def scene_of(summary: FlightSummary, most: int) -> Scene:
    """Return what a map shows of a flight, the way in about `most` points."""
    last = summary.believed_at
    believed = (float(last.x_m[0]), float(last.y_m[0])) if len(last) else None
    truth, missing_ns = summary.truth.thinned(most), summary.link.missing_ns
    return Scene(truth, summary.waypoints, believed, summary.setting, summary.returns, missing_ns)


WAY: Final = "cyan"
UNHEARD: Final = "bright_black"  # the way where nothing could be sent from
WAY_HOME: Final = "yellow"
ROBOT: Final = "bold green"
BELIEF: Final = "bold magenta"
HOME: Final = "bold yellow"
LOST: Final = "red"
KEEP_IN: Final = "dim green"
KEEP_OUT: Final = "red"
_STATUS_STYLES: Final = {
    WaypointStatus.REACHED: "green",
    WaypointStatus.TIMED_OUT: "red",
    WaypointStatus.SKIPPED: "red",
    WaypointStatus.OPEN: "yellow",
}
_MARGIN: Final = 0.04  # of the larger side, around everything
_BELIEF: Final = "last known position"
_SHORT: Final = {_BELIEF: "last known"}  # where the whole legend has no room


@dataclass(frozen=True, slots=True)
class _Frame:
    """From metres to dots, the same scale along both axes."""

    left_m: float
    top_m: float
    dots_per_m: float

    def dots(self, x_m: Metres, y_m: Metres) -> tuple[Metres, Metres]:
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
    for zone in scene.setting.zones:
        corners = np.array([*zone.outline_m, zone.outline_m[0]])
        canvas.polyline(*frame.dots(corners[:, 0], corners[:, 1]), KEEP_IN if zone.keep_in else KEEP_OUT)
    for waypoint in scene.waypoints:
        canvas.polyline(*frame.dots(*_region(waypoint)), _STATUS_STYLES[waypoint.status])
    _draw_way(canvas, frame, scene)
    signs = tuple(_signs(scene, ascii_only))
    lost, *others = signs
    for sign in others:
        for place in sign.places:
            canvas.sign(*frame.dots(*place), sign.letter, sign.style)
    for waypoint in scene.waypoints:
        _name_waypoint(canvas, frame, waypoint)
    for zone in scene.setting.zones:
        _name_zone(canvas, frame, zone)
    for place in lost.places:  # last, where there is room: a link can lose thousands
        _write(canvas, lost.letter, [frame.dots(*place)], lost.style)
    return [*canvas.rows(ascii_only=ascii_only), _legend(frame, columns, signs, ascii_only)]


def _draw_way(canvas: Canvas, frame: _Frame, scene: Scene) -> None:
    """Draw the path driven: places without contact in another style, and returns home in a third."""
    truth, down = scene.truth, scene.setting.down
    canvas.polyline(*frame.dots(truth.x_m, truth.y_m), WAY)
    if down is not None:
        lost_spans = truth.at(np.flatnonzero(~down.is_open(truth.time_ns)))
        canvas.dots(*frame.dots(lost_spans.x_m, lost_spans.y_m), UNHEARD)
    for each in scene.returns:
        end_ns = int(truth.time_ns[-1]) if each.ended_ns is None and len(truth) else each.ended_ns or 0
        way = truth.between(each.began_ns, end_ns)
        canvas.polyline(*frame.dots(way.x_m, way.y_m), WAY_HOME)


@dataclass(frozen=True, slots=True)
class _Sign:
    """A letter that stands for something, where it is, and its text in the legend, if any."""

    letter: str
    style: str
    text: str
    places: Sequence[tuple[float, float]]


def _signs(scene: Scene, ascii_only: bool) -> Iterator[_Sign]:
    """Yield the signs of a map, each over those before it."""
    truth = scene.truth
    lost = truth.nearest(scene.missing_ns)
    count = f"{len(lost)} not delivered" if len(lost) else ""
    places = list(zip(lost.x_m.tolist(), lost.y_m.tolist(), strict=True))
    yield _Sign("x" if ascii_only else "\N{MULTIPLICATION SIGN}", LOST, count, places)
    if len(truth):
        yield _Sign("+", WAY, "", [(float(truth.x_m[0]), float(truth.y_m[0]))])
    if scene.home is not None:
        yield _Sign("H" if ascii_only else "⌂", HOME, "home", [scene.home])
    belief = [] if scene.belief is None else [scene.belief]
    yield _Sign("o" if ascii_only else "◇", BELIEF, _BELIEF if belief else "", belief)
    robot = [(float(truth.x_m[-1]), float(truth.y_m[-1]))] if len(truth) else []
    yield _Sign("@" if ascii_only else "●", ROBOT, "robot", robot)


def _region(waypoint: WaypointSummary) -> tuple[FloatArray, FloatArray]:
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
    home_x_m, home_y_m = zip(scene.home, strict=True) if scene.home is not None else ((), ())
    x_m = np.concatenate([scene.truth.x_m, *(outline[0] for outline in outlines), home_x_m])
    y_m = np.concatenate([scene.truth.y_m, *(outline[1] for outline in outlines), home_y_m])
    shown = extent(x_m, y_m, scene.setting.zones)
    wide, high = shown.right_m - shown.left_m, shown.top_m - shown.bottom_m
    margin = max(wide, high) * _MARGIN
    scale = min(canvas.width / (wide + 2 * margin), canvas.height / (high + 2 * margin))
    center_x, center_y = (shown.left_m + shown.right_m) / 2, (shown.bottom_m + shown.top_m) / 2
    return _Frame(center_x - canvas.width / scale / 2, center_y + canvas.height / scale / 2, scale)


def _name_waypoint(canvas: Canvas, frame: _Frame, waypoint: WaypointSummary) -> None:
    """Write the waypoint's name beside its region, on whichever side there is room."""
    plan, name = waypoint.planned, shortened(waypoint.planned.name)
    x, y = frame.dots(plan.x_m, plan.y_m)
    reach = plan.tolerance_m * frame.dots_per_m
    length = cell_len(name)
    right, left = x + reach + CELL_WIDTH, x - reach - CELL_WIDTH * (length + 1)
    middle = x - CELL_WIDTH * (length // 2)
    places = ((right, y), (left, y), (middle, y - reach - CELL_HEIGHT), (middle, y + reach + CELL_HEIGHT))
    _write(canvas, name, places, _STATUS_STYLES[waypoint.status])


def _name_zone(canvas: Canvas, frame: _Frame, zone: Zone) -> None:
    """Write the zone's name in what is on the map of it, at its top or its bottom, or beside it if it is too small."""
    name = shortened(zone.label)
    length = CELL_WIDTH * cell_len(name)
    x, y = frame.dots(*np.array(zone.outline_m).T)
    left, right = max(float(x.min()), 0.0), min(float(x.max()), canvas.width)
    top, bottom = max(float(y.min()), 0.0), min(float(y.max()), canvas.height)
    middle, center = (left + right - length) / 2, (top + bottom) / 2
    places = [(middle, top + CELL_HEIGHT), (middle, bottom - CELL_HEIGHT - 1), (middle, center)]
    if right - left < length:
        places = [(middle, bottom + CELL_HEIGHT), (middle, top - CELL_HEIGHT)]
        places += [(right + CELL_WIDTH, center), (left - CELL_WIDTH - length, center)]
    _write(canvas, name, places, KEEP_IN if zone.keep_in else KEEP_OUT)


def _write(canvas: Canvas, name: str, places: Sequence[tuple[float, float]], style: str) -> None:
    """Write a name at that of some places where it covers little that is drawn and nothing that is written, if any."""
    free = [place for place in places if canvas.is_free(*place, name)]
    if free:
        canvas.sign(*min(free, key=lambda place: canvas.covered(place[0], place[1], name)), name, style)


def _legend(frame: _Frame, columns: int, signs: Sequence[_Sign], ascii_only: bool) -> Text:
    """Return the scale and the signs; of these, whole ones as far as there is room."""
    legend = Text(no_wrap=True, overflow="crop")
    length_m = _roundcell_len(columns / 5 * CELL_WIDTH / frame.dots_per_m)
    cells = max(2, round(length_m * frame.dots_per_m / CELL_WIDTH))
    legend.append("|" + "-" * (cells - 2) + "|" if ascii_only else "├" + "─" * (cells - 2) + "┤", "dim")
    legend.append(f" {length_m:g} m", "dim")
    shown = [sign for sign in reversed(signs) if sign.text]
    if legend.cell_len + sum(len(sign.text) + 4 for sign in shown) > columns:
        shown = [replace(sign, text=_SHORT.get(sign.text, sign.text)) for sign in shown]
    for sign in shown:
        if legend.cell_len + len(sign.text) + 4 <= columns:
            legend.append("  ").append(sign.letter, sign.style).append(f" {sign.text}", "dim")
    legend.truncate(columns)
    return legend


def _roundcell_len(length_m: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not above `length_m`."""
    power = 10.0 ** math.floor(math.log10(length_m))
    return next(step * power for step in (5, 2, 1) if step * power <= length_m * (1 + 1e-9))
