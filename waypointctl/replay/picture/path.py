"""The map: acceptance regions, the way walked, and where the operator believed the robot at each waypoint."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Patch, Rectangle

from waypointctl.log.messages import PlannedWaypoint
from waypointctl.replay.picture import palette
from waypointctl.replay.story import Story, WaypointStory
from waypointctl.units import seconds

_POINTS: Final = 6000  # drawn of the way
_MARGIN: Final = 0.08


def draw_path(axes: Axes, story: Story) -> None:
    """Draw the map of a story, metres in equal scale along both axes."""
    for waypoint in story.waypoints:
        _draw_waypoint(axes, waypoint)
    way, told = story.truth.thinned(_POINTS), story.belief.thinned(_POINTS)
    axes.plot(way.x_m, way.y_m, color=palette.ROBOT, linewidth=1.8, label="robot, truth", zorder=3)
    axes.plot(
        told.x_m, told.y_m, ".", color=palette.OPERATOR, markersize=3.5, alpha=0.55, label="telemetry frame", zorder=4
    )
    if len(way):
        axes.plot(way.x_m[0], way.y_m[0], "o", color="white", markeredgecolor=palette.INK, label="start", zorder=5)
        axes.plot(way.x_m[-1], way.y_m[-1], "s", color=palette.INK, markersize=6, label="end", zorder=5)
    _draw_beliefs(axes, story)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(_MARGIN)
    axes.set(xlabel="x [m]", ylabel="y [m]", title="Path")
    axes.grid(color=palette.FAINT, linewidth=0.4)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.07), ncols=3, frameon=False, fontsize=9)


def _draw_waypoint(axes: Axes, waypoint: WaypointStory) -> None:
    plan, color = waypoint.planned, palette.FATES[waypoint.fate]
    axes.add_patch(_region(plan, color))
    when = str(waypoint.fate) if waypoint.reached_ns is None else f"{seconds(waypoint.reached_ns):.2f} s"
    axes.annotate(
        f"{plan.name}\n{when}",
        (plan.x_m + plan.tolerance_m, plan.y_m + plan.tolerance_m),
        xytext=(3, 3),
        textcoords="offset points",
        fontsize=9,
        color=color,
        zorder=6,
        bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 1.0},
    )


def _region(plan: PlannedWaypoint, color: str) -> Patch:
    reach = plan.tolerance_m
    look = {"facecolor": f"{color}33", "edgecolor": color, "linewidth": 1.2, "zorder": 2}
    if plan.acceptance == "box":
        return Rectangle((plan.x_m - reach, plan.y_m - reach), 2 * reach, 2 * reach, **look)
    return Circle((plan.x_m, plan.y_m), reach, **look)


def _draw_beliefs(axes: Axes, story: Story) -> None:
    """At the moment the robot reached a waypoint, join it to where the operator believed it to be just then."""
    label = "believed at that moment"
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
