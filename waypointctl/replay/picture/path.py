"""The map: zones, acceptance regions, home, the path, and the position known to the operator at each waypoint."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Patch, Polygon, Rectangle
from matplotlib.ticker import MultipleLocator

from waypointctl.figure import FAINT, INK
from waypointctl.log.messages import PlannedWaypoint
from waypointctl.mission.onboard import Zone
from waypointctl.replay.legs import WaypointSummary
from waypointctl.replay.picture.labels import (
    FAILED,
    HOME,
    KEEP_IN,
    KEEP_OUT,
    OPERATOR,
    ROBOT,
    STATUS_COLORS,
    Labels,
    Place,
    around,
    short,
)
from waypointctl.replay.picture.time_axis import time_text
from waypointctl.replay.summary import FlightSummary
from waypointctl.replay.track import Track, extent, is_on_map
from waypointctl.units import seconds

_POINTS: Final = 6000  # drawn of the way
_MOST_LOST: Final = 300  # crosses drawn of messages that were not delivered
MANY: Final = 60  # above that many waypoints they are drawn faintly, and known positions are left out
_MOST_TIMES: Final = 12  # above that many waypoints their labels would cover each other
_LETTERS: Final = 24  # of a name
_MARGIN: Final = 0.08  # of the larger side, all round
_HOUSE: Final = ((-1.0, -1.0), (1.0, -1.0), (1.0, 0.3), (0.0, 1.2), (-1.0, 0.3), (-1.0, -1.0))
_HOME_LOOK: Final[dict[str, Any]] = {"color": "white", "markeredgecolor": HOME, "markersize": 11}


def draw_path(axes: Axes, summary: FlightSummary) -> None:
    """Draw the map of a summary, metres in equal scale along both axes."""
    waypoints = [waypoint for waypoint in summary.waypoints if waypoint.is_on_map]
    for zone in summary.setting.zones:
        axes.add_patch(_zone(zone))
    for waypoint in waypoints:
        axes.add_patch(_region(waypoint.planned, STATUS_COLORS[waypoint.status], faint=len(waypoints) > MANY))
    way = summary.truth.thinned(_POINTS)
    _draw_way(axes, summary, way)
    if len(waypoints) <= MANY:
        _draw_known_positions(axes, summary)
    if summary.home is not None:
        axes.plot(
            summary.home.x_m, summary.home.y_m, marker=_HOUSE, label="home", linestyle="none", zorder=5, **_HOME_LOOK
        )
    _draw_lost(axes, summary)
    places = [place for place in summary.places if is_on_map(place.x_m, place.y_m, place.tolerance_m)]
    _draw_places(axes, places)
    _set_limits(axes, summary, [*(waypoint.planned for waypoint in waypoints), *places], way)
    axes.set(xlabel="x [m]", ylabel="y [m]", title="Path")
    axes.grid(color=FAINT, linewidth=0.4)
    if axes.get_legend_handles_labels()[0]:
        below: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.06)}
        axes.legend(**below, ncols=4, frameon=False, fontsize=9, columnspacing=1.2)
    _write_names(axes, summary, waypoints, places, way)


def _draw_way(axes: Axes, summary: FlightSummary, way: Track) -> None:
    if len(way):
        axes.plot(way.x_m, way.y_m, color=ROBOT, linewidth=1.8, label="robot, truth", zorder=3)
    for number, each in enumerate(summary.returns):
        home = summary.truth.between(each.began_ns, summary.ended_ns if each.ended_ns is None else each.ended_ns)
        home = home.thinned(_POINTS)
        label = "_nolegend_" if number else "way home"
        axes.plot(home.x_m, home.y_m, color=HOME, linewidth=2.6, label=label, zorder=3)
    if summary.setting.down is not None:
        lost_spans = np.where(summary.setting.down.is_open(way.time_ns), np.nan, 1.0)
        label = "hollow: no contact down" if np.isfinite(lost_spans).any() else "_nolegend_"
        look: dict[str, Any] = {"color": "white", "linewidth": 0.9, "zorder": 3.5}
        axes.plot(way.x_m * lost_spans, way.y_m * lost_spans, **look)
        axes.plot([], [], color=FAINT, linewidth=2.2, label=label)
    known = summary.belief.thinned(_POINTS)
    if len(known):
        axes.plot(known.x_m, known.y_m, ".", color=OPERATOR, markersize=5, label="telemetry frame", zorder=4)
    if len(way):
        axes.plot(way.x_m[0], way.y_m[0], "o", color="white", markeredgecolor=INK, label="start", zorder=5)
        axes.plot(way.x_m[-1], way.y_m[-1], "s", color=INK, markersize=6, label="end", zorder=5)


def _draw_places(axes: Axes, places: Sequence[PlannedWaypoint]) -> None:
    """Mark the places of go_to commands that are none of the mission's waypoints."""
    if places:
        x_m, y_m = [place.x_m for place in places], [place.y_m for place in places]
        look: dict[str, Any] = {"color": INK, "linestyle": "none", "zorder": 4.5}
        few = len(places) <= _MOST_TIMES
        axes.plot(x_m, y_m, "+", markersize=10 if few else 4, label="commanded place", **look)


def _draw_lost(axes: Axes, summary: FlightSummary) -> None:
    """Mark where the robot was when messages were sent that were not delivered."""
    missing_ns = summary.link.missing_ns
    lost = summary.truth.nearest(missing_ns).thinned(_MOST_LOST)
    if len(lost):
        label = f"{len(missing_ns)} not delivered"
        axes.plot(lost.x_m, lost.y_m, "x", color=FAILED, markersize=4, label=label, zorder=4.5)


def _set_limits(axes: Axes, summary: FlightSummary, goals: Sequence[PlannedWaypoint], way: Track) -> None:
    """Show the way, the goals, home and what is near of the zones, in equal scale, with ticks equally far apart."""
    plans = [*goals] + ([] if summary.home is None else [summary.home])
    reach = np.array([plan.tolerance_m for plan in plans])
    x_m, y_m = (np.array([getattr(plan, name) for plan in plans]) for name in ("x_m", "y_m"))
    known = summary.belief
    shown = extent(
        np.concatenate([way.x_m, known.x_m, x_m - reach, x_m + reach]),
        np.concatenate([way.y_m, known.y_m, y_m - reach, y_m + reach]),
        summary.setting.zones,
    )
    room = axes.get_window_extent()
    wide_m, high_m = shown.right_m - shown.left_m, shown.top_m - shown.bottom_m
    margin_m = 2 * _MARGIN * max(wide_m, high_m)
    pixel_m = max((wide_m + margin_m) / room.width, (high_m + margin_m) / room.height)
    middle_m, center_m = (shown.left_m + shown.right_m) / 2, (shown.bottom_m + shown.top_m) / 2
    axes.set_xlim(middle_m - pixel_m * room.width / 2, middle_m + pixel_m * room.width / 2)
    axes.set_ylim(center_m - pixel_m * room.height / 2, center_m + pixel_m * room.height / 2)
    extent_m = pixel_m * max(room.width, room.height)
    power = 10.0 ** np.floor(np.log10(extent_m / 8))
    step_m = next(step * power for step in (1, 2, 5, 10) if step * power >= extent_m / 8)
    axes.xaxis.set_major_locator(MultipleLocator(step_m))
    axes.yaxis.set_major_locator(MultipleLocator(step_m))


def _write_names(
    axes: Axes,
    summary: FlightSummary,
    waypoints: Sequence[WaypointSummary],
    places: Sequence[PlannedWaypoint],
    way: Track,
) -> None:
    """Write the names of waypoints, home and zones where they cover no other, and little of the way."""
    labels = Labels(axes, axes.transData.transform(np.column_stack([way.x_m, way.y_m])))
    with_time = len(waypoints) <= _MOST_TIMES
    for waypoint in waypoints:
        plan, color = waypoint.planned, STATUS_COLORS[waypoint.status]
        name = short(plan.name, _LETTERS)
        when = str(waypoint.status) if waypoint.reached_ns is None else time_text(seconds(waypoint.reached_ns))
        around_it = around(*_box(labels, plan))
        if not with_time or not labels.put(f"{name}\n{when}", around_it, color, size_pt=9):
            labels.put(name, around_it, color, size_pt=9)
    for place in places if len(places) <= _MOST_TIMES else ():
        x_px, y_px = labels.pixels(place.x_m, place.y_m)
        labels.put(short(place.name, _LETTERS), around(x_px - 5, x_px + 5, y_px - 5, y_px + 5), INK)
    if summary.home is not None:
        x_px, y_px = labels.pixels(summary.home.x_m, summary.home.y_m)
        labels.put("home", around(x_px - 8, x_px + 8, y_px - 8, y_px + 8), HOME, size_pt=9)
    for zone in summary.setting.zones:
        color = KEEP_IN if zone.keep_in else KEEP_OUT
        labels.put(short(zone.label, _LETTERS + 9), _zone_places(axes, labels, zone), color)


def _box(labels: Labels, plan: PlannedWaypoint) -> tuple[float, float, float, float]:
    left, bottom = labels.pixels(plan.x_m - plan.tolerance_m, plan.y_m - plan.tolerance_m)
    right, top = labels.pixels(plan.x_m + plan.tolerance_m, plan.y_m + plan.tolerance_m)
    return left, right, bottom, top


def _zone_places(axes: Axes, labels: Labels, zone: Zone) -> Sequence[Place]:
    """Return places in what is on the map of a zone, and then around it."""
    corners, room = np.array([labels.pixels(*corner) for corner in zone.outline_m]), axes.get_window_extent()
    left, right = np.clip((corners[:, 0].min(), corners[:, 0].max()), room.x0, room.x1)
    bottom, top = np.clip((corners[:, 1].min(), corners[:, 1].max()), room.y0, room.y1)
    middle, center = (left + right) / 2, (bottom + top) / 2
    within = (Place(middle, top - 4, "center", "top"), Place(middle, bottom + 4, "center"))
    return (*within, Place(middle, center, "center", "center"), *around(left, right, bottom, top))


def _zone(zone: Zone) -> Patch:
    if zone.keep_in:
        return Polygon(zone.outline_m, facecolor="none", edgecolor=KEEP_IN, linestyle="--", linewidth=1.4)
    look: dict[str, Any] = {"facecolor": f"{KEEP_OUT}18", "edgecolor": KEEP_OUT, "linewidth": 1.2}
    return Polygon(zone.outline_m, hatch="xx", hatch_linewidth=0.3, **look)


def _region(plan: PlannedWaypoint, color: str, *, faint: bool) -> Patch:
    reach = plan.tolerance_m
    region: Patch
    if plan.acceptance == "box":
        region = Rectangle((plan.x_m - reach, plan.y_m - reach), 2 * reach, 2 * reach)
    else:
        region = Circle((plan.x_m, plan.y_m), reach)
    fill, width = ("08", 0.3) if faint else ("33", 1.2)
    region.set(facecolor=f"{color}{fill}", edgecolor=color, linewidth=width, zorder=2)
    return region


def _draw_known_positions(axes: Axes, summary: FlightSummary) -> None:
    """At the moment the robot reached a waypoint, join it to where the operator believed it to be just then."""
    label = "known when reached"
    news = summary.belief.newest()
    for waypoint in summary.waypoints:
        if waypoint.reached_ns is None:
            continue
        there = np.searchsorted(summary.truth.time_ns, waypoint.reached_ns, "right") - 1
        known = np.searchsorted(news.known_ns, waypoint.reached_ns, "right") - 1
        if there < 0 or known < 0:
            continue
        x_m = [news.x_m[known], summary.truth.x_m[there]]
        y_m = [news.y_m[known], summary.truth.y_m[there]]
        axes.plot(x_m, y_m, ":", color=OPERATOR, linewidth=1.0, zorder=4)
        axes.plot(x_m[:1], y_m[:1], "D", color="white", markeredgecolor=OPERATOR, label=label, zorder=5)
        label = "_nolegend_"
