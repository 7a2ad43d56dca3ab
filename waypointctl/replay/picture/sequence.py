"""The messages between operator and robot, each an arrow from its issue to its delivery."""

from __future__ import annotations

from itertools import groupby
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from waypointctl.log.messages import Stage
from waypointctl.replay.picture import palette
from waypointctl.replay.story import CommandStory, Story, WaypointStory
from waypointctl.units import NS_PER_S, seconds

_OPERATOR_Y: Final = 1.0
_ROBOT_Y: Final = 0.0
_MOST_FRAMES: Final = 150  # drawn of telemetry
_MOST_NAMES: Final = 12  # above that many commands their names would cover each other
_WALK_WIDTH: Final = 7
_WALK_ALPHA: Final = 0.35
# How far below the robot's line a stage is written [pt]: beginnings and ends in rows of their own.
_BEGIN_PT: Final = -6
_END_PT: Final = -18
_DROPS: Final = {
    Stage.STARTED: _BEGIN_PT,
    Stage.REJECTED: _BEGIN_PT,
    Stage.COMPLETED: _END_PT,
    Stage.FAILED: _END_PT,
}
_BAD: Final = (Stage.FAILED, Stage.REJECTED)


def draw_sequence(axes: Axes, story: Story) -> None:
    """Draw the sequence of a story's messages over time [s], operator above, robot below."""
    for y, color in ((_OPERATOR_Y, palette.OPERATOR), (_ROBOT_Y, palette.ROBOT)):
        axes.axhline(y, color=color, linewidth=1.4)
    _draw_telemetry(axes, story)
    named = len(story.commands) <= _MOST_NAMES
    for command in story.commands:
        _draw_command(axes, command, story.ended_ns, named)
    for waypoint in story.waypoints:
        _draw_waypoint(axes, waypoint, story.ended_ns)
    axes.set_ylim(-0.26, 1.2)
    axes.set_yticks([_ROBOT_Y, _OPERATOR_Y], ["robot", "operator"])
    axes.set(xlabel="simulation time [s]", title="Messages")
    axes.grid(axis="x", color=palette.FAINT, linewidth=0.4)
    axes.legend(
        handles=_keys(),
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=6,
        frameon=False,
        fontsize=9,
        borderaxespad=0.2,
        columnspacing=1.2,
        handlelength=1.5,
    )


def _keys() -> list[Line2D]:
    return [
        Line2D([], [], color=palette.OPERATOR, label="command"),
        Line2D([], [], color=palette.ROBOT, label="acknowledgement"),
        Line2D([], [], color=palette.FAINT, label="telemetry"),
        Line2D([], [], color=palette.ROBOT, linewidth=_WALK_WIDTH, alpha=_WALK_ALPHA, label="walking"),
        _dot(palette.REACHED, "reached"),
        _dot("white", "known"),
    ]


def _dot(color: str, label: str) -> Line2D:
    return Line2D([], [], color=color, marker="o", linestyle="none", markeredgecolor=palette.REACHED, label=label)


def _draw_waypoint(axes: Axes, waypoint: WaypointStory, ended_ns: int) -> None:
    if waypoint.started_ns is not None:
        leg = [seconds(waypoint.started_ns), seconds(ended_ns if waypoint.ended_ns is None else waypoint.ended_ns)]
        axes.plot(leg, [_ROBOT_Y] * 2, color=palette.ROBOT, linewidth=_WALK_WIDTH, alpha=_WALK_ALPHA, zorder=2)
    if waypoint.reached_ns is not None:
        axes.plot(seconds(waypoint.reached_ns), _ROBOT_Y, "o", color=palette.REACHED, markersize=7, zorder=5)
    if waypoint.learned_ns is not None:
        at_s = seconds(waypoint.learned_ns)
        axes.plot(at_s, _OPERATOR_Y, "o", color="white", markeredgecolor=palette.REACHED, markersize=7, zorder=5)


def _draw_telemetry(axes: Axes, story: Story) -> None:
    frames = story.belief.thinned(_MOST_FRAMES)
    ends = np.full(len(frames), _ROBOT_Y), np.full(len(frames), _OPERATOR_Y)
    starts = np.column_stack([frames.time_ns / NS_PER_S, ends[0]])
    stops = np.column_stack([frames.known_ns / NS_PER_S, ends[1]])
    lines = np.stack([starts, stops], axis=1)
    axes.add_collection(LineCollection(list(lines), colors=palette.FAINT, linewidths=0.5, zorder=1))


def _draw_command(axes: Axes, command: CommandStory, ended_ns: int, named: bool) -> None:
    issued_s = seconds(command.issued_ns)
    text = f"{command.id}: {command.what}" if named else ""
    if command.received_ns is None:
        # It was under way when the flight ended: how far it had come is not known, so its line has no head.
        axes.plot([issued_s, seconds(ended_ns)], [_OPERATOR_Y, 0.5], "--", color=palette.FAILED, linewidth=1.2)
        text = f"{text} (under way)"
    else:
        _arrow(axes, issued_s, _OPERATOR_Y, seconds(command.received_ns), _ROBOT_Y, palette.OPERATOR)
    _label(axes, issued_s, _OPERATOR_Y, text, palette.OPERATOR, 5)
    for (issued_ns, received_ns), acks in groupby(command.acks, lambda ack: (ack.issued_ns, ack.received_ns)):
        last = list(acks)[-1]
        color = palette.FAILED if last.stage in _BAD else palette.ROBOT
        _arrow(axes, seconds(issued_ns), _ROBOT_Y, seconds(received_ns), _OPERATOR_Y, color)
        if named and last.stage in _DROPS:
            _label(axes, seconds(issued_ns), _ROBOT_Y, f"{last.command_id} {last.stage}", color, _DROPS[last.stage])


def _arrow(axes: Axes, from_s: float, from_y: float, to_s: float, to_y: float, color: str) -> None:
    look = {"arrowstyle": "-|>", "color": color, "linewidth": 1.3, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (to_s, to_y), (from_s, from_y), arrowprops=look, zorder=4, annotation_clip=False)


def _label(axes: Axes, time_s: float, y: float, text: str, color: str, rise_pt: int) -> None:
    axes.annotate(
        text,
        (time_s, y),
        xytext=(0, rise_pt),
        textcoords="offset points",
        va="bottom" if rise_pt > 0 else "top",
        # The end of a command is written before its moment: at the end of the flight there is no room after it.
        ha="right" if rise_pt < _BEGIN_PT else "left",
        fontsize=8,
        color=color,
    )
