"""The map: acceptance regions, the way walked, and where the operator believed the robot at each waypoint."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Patch, Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MultipleLocator

from waypointctl.log.messages import PlannedWaypoint
from waypointctl.replay.picture import palette
from waypointctl.replay.story import Story, WaypointStory
from waypointctl.units import seconds

_POINTS: Final = 6000  # drawn of the way
_MOST_TIMES: Final = 12  # above that many waypoints their labels would cover each other
_MARGIN: Final = 0.08


def draw_path(axes: Axes, story: Story) -> None:
    """Draw the map of a story, metres in equal scale along both axes."""
    for waypoint in story.waypoints:
        if waypoint.is_on_map:
            _draw_waypoint(axes, waypoint, with_time=len(story.waypoints) <= _MOST_TIMES)
    way, told = story.truth.thinned(_POINTS), story.belief.thinned(_POINTS)
    axes.plot(way.x_m, way.y_m, color=palette.ROBOT, linewidth=1.8, label="robot, truth", zorder=3)
    axes.plot(told.x_m, told.y_m, ".", color=palette.OPERATOR, markersize=5, label="telemetry frame", zorder=4)
    if len(way):
        axes.plot(way.x_m[0], way.y_m[0], "o", color="white", markeredgecolor=palette.INK, label="start", zorder=5)
        axes.plot(way.x_m[-1], way.y_m[-1], "s", color=palette.INK, markersize=6, label="end", zorder=5)
    _draw_beliefs(axes, story)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(_MARGIN)
    axes.set(xlabel="x [m]", ylabel="y [m]", title="Path")
    axes.grid(color=palette.FAINT, linewidth=0.4)
    _set_ticks(axes)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.065), ncols=5, frameon=False, fontsize=9, columnspacing=1.2)


def _set_ticks(axes: Axes) -> None:
    """Set the ticks of both axes the same distance apart."""
    drawn = axes.dataLim  # of everything: ticks for less than that could be millions
    extent_m = max(drawn.width, drawn.height, 1.0)  # minus infinity, where nothing is drawn
    power = 10.0 ** np.floor(np.log10(extent_m / 8))
    step_m = next(step * power for step in (1, 2, 5, 10) if step * power >= extent_m / 8)
    axes.xaxis.set_major_locator(MultipleLocator(step_m))
    axes.yaxis.set_major_locator(MultipleLocator(step_m))


def _draw_waypoint(axes: Axes, waypoint: WaypointStory, *, with_time: bool) -> None:
    plan, color = waypoint.planned, palette.FATES[waypoint.fate]
    axes.add_patch(_region(plan, color))
    when = str(waypoint.fate) if waypoint.reached_ns is None else f"{seconds(waypoint.reached_ns):.2f} s"
    axes.annotate(
        f"{plan.name}\n{when}" if with_time else plan.name,
        (plan.x_m + plan.tolerance_m, plan.y_m + plan.tolerance_m),
        xytext=(3, 3),
        textcoords="offset points",
        fontsize=9,
        color=color,
        zorder=6,
        path_effects=[withStroke(linewidth=2.5, foreground="white")],
    )


def _region(plan: PlannedWaypoint, color: str) -> Patch:
    reach = plan.tolerance_m
    region: Patch
    if plan.acceptance == "box":
        region = Rectangle((plan.x_m - reach, plan.y_m - reach), 2 * reach, 2 * reach)
    else:
        region = Circle((plan.x_m, plan.y_m), reach)
    region.set(facecolor=f"{color}33", edgecolor=color, linewidth=1.2, zorder=2)
    return region


def _draw_beliefs(axes: Axes, story: Story) -> None:
    """At the moment the robot reached a waypoint, join it to where the operator believed it to be just then."""
    label = "belief when reached"
    for waypoint in story.waypoints:
        if waypoint.reached_ns is None:
            continue
        there = np.searchsorted(story.truth.time_ns, waypoint.reached_ns, "right") - 1
        known = np.searchsorted(story.belief.known_ns, waypoint.reached_ns, "right") - 1
        if there < 0 or known < 0:
            continue
        x_m = [story.belief.x_m[known], story.truth.x_m[there]]
        y_m = [story.belief.y_m[known], story.truth.y_m[there]]
        axes.plot(x_m, y_m, ":", color=palette.OPERATOR, linewidth=1.0, zorder=4)
        axes.plot(x_m[:1], y_m[:1], "D", color="white", markeredgecolor=palette.OPERATOR, label=label, zorder=5)
        label = "_nolegend_"
