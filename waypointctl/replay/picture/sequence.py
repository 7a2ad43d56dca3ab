"""The messages between operator and robot, each an arrow from its issue to its delivery, and when the link is there."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import compress, groupby
from operator import not_
from typing import Final

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from waypointctl.figure import FAINT
from waypointctl.log.header import Span
from waypointctl.log.messages import Ack, Stage
from waypointctl.replay.command_summary import CommandSummary
from waypointctl.replay.picture.labels import FAILED, HOME, OPERATOR, REACHED, ROBOT, Labels, Place, short
from waypointctl.replay.summary import FlightSummary
from waypointctl.units import NS_PER_S, seconds

_OPERATOR_Y: Final = 1.0
_ROBOT_Y: Final = 0.0
_UNHEARD_Y: Final = -0.285  # below the labels
_LOST_Y: Final = 0.12  # how far a message that is lost is drawn on its way
_LIMITS: Final = (-0.31, 1.27)
_MOST_FRAMES: Final = 150  # drawn of telemetry
_MOST_LOST: Final = 400  # drawn of messages that were not delivered
_MOST_ARROWS: Final = 40  # above that many commands they are lines without heads
_MOST_WINDOWS: Final = 1000  # drawn
_WALK_WIDTH: Final = 7
_WALK_ALPHA: Final = 0.35
_LETTERS: Final = 30  # of a command
_ROWS_PX: Final = (8.0, 25.0, 42.0)  # how far from its line a label stands
_TOLD: Final = (Stage.STARTED, Stage.REJECTED, Stage.COMPLETED, Stage.FAILED, Stage.CANCELLED, Stage.EXPIRED)
_BAD: Final = (Stage.FAILED, Stage.REJECTED)


def draw_sequence(axes: Axes, summary: FlightSummary) -> None:
    """Draw the sequence of a summary's messages over time [s], operator above, robot below."""
    for y, color in ((_OPERATOR_Y, OPERATOR), (_ROBOT_Y, ROBOT)):
        axes.axhline(y, color=color, linewidth=1.4)
    axes.set_ylim(*_LIMITS)
    axes.set_yticks([_ROBOT_Y, _OPERATOR_Y], ["robot", "operator"])
    axes.set(title="Messages")
    _draw_contact(axes, summary)
    _draw_telemetry(axes, summary)
    _draw_commands(axes, summary)
    _draw_lost(axes, summary)
    _draw_robot(axes, summary)
    axes.grid(axis="x", color=FAINT, linewidth=0.4)
    keys = list(_keys(summary))
    axes.legend(
        handles=keys,
        loc="upper center",
        bbox_to_anchor=(0.5, -0.17),
        ncols=5,
        frameon=False,
        fontsize=9,
        borderaxespad=0.2,
        columnspacing=1.2,
        handlelength=1.5,
    )


def name_messages(axes: Axes, summary: FlightSummary) -> None:
    """Write commands and what became of them beside their moments, where there is room; limits are set by now."""
    labels = Labels(axes)
    is_wrong = [command.onboard in _BAD or command.received_ns is None for command in summary.commands]
    wrong, others = (tuple(compress(summary.commands, which)) for which in (is_wrong, map(not_, is_wrong)))
    if len(summary.commands) > _MOST_ARROWS:
        others = ()
        axes.set_title(f"Messages ({len(summary.commands)} commands; only failures are labelled)")
    for command in (*wrong, *others):
        at_px, y_px = labels.pixels(seconds(command.issued_ns), _OPERATOR_Y)
        state = "" if command.received_ns is not None else f" ({_undelivered(command)})"
        color = FAILED if state else OPERATOR
        labels.put(f"{command.id}: {short(command.description, _LETTERS)}{state}", _rows(at_px, y_px, +1), color)
        for ack in _labelled(command.acks):
            at_px, y_px = labels.pixels(seconds(ack.issued_ns), _ROBOT_Y)
            color = FAILED if ack.stage in _BAD else ROBOT
            labels.put(f"{ack.command_id} {ack.stage}", _rows(at_px, y_px, -1), color)
    if labels.left_out and len(summary.commands) <= _MOST_ARROWS:
        axes.set_title(f"Messages (labels left out for lack of room: {labels.left_out})")


def _rows(at_px: float, y_px: float, side: int) -> Iterable[Place]:
    """Return places above (+1) or below (-1) a moment, in rows, after it or before it."""
    for row_px in _ROWS_PX:
        for horizontal, aside_px in (("left", 2.0), ("right", -2.0)):
            yield Place(at_px + aside_px, y_px + side * row_px, horizontal, "bottom" if side > 0 else "top")


def _undelivered(command: CommandSummary) -> str:
    return "not delivered" if command.losses >= command.attempts else "under way"


def _labelled(acks: Sequence[Ack]) -> Iterable[Ack]:
    """Yield the last of those acknowledgements that were sent and have arrived together, that are worth a label."""
    for _, together in groupby(acks, lambda ack: (ack.issued_ns, ack.received_ns)):
        last = list(together)[-1]
        if last.stage in _TOLD:
            yield last


def _keys(summary: FlightSummary) -> Iterable[Artist]:
    """Yield an entry for each kind of thing that is drawn."""
    yield from _message_keys(summary)
    yield from _robot_keys(summary)
    if len(summary.link.missing_ns):
        text = f"{len(summary.link.missing_ns)} not delivered"
        yield Line2D([], [], color=FAILED, marker="x", markersize=5, linestyle="none", label=text)
    if summary.setting.up is not None or summary.setting.down is not None:
        yield Patch(facecolor=FAINT, alpha=0.35, label="no contact")
    if summary.link.lost_spans:
        yield Line2D([], [], color=FAILED, linewidth=3, label="link lost, on board")


def _message_keys(summary: FlightSummary) -> Iterable[Artist]:
    if any(command.received_ns is not None for command in summary.commands):
        yield Line2D([], [], color=OPERATOR, label="command")
    if any(command.acks for command in summary.commands):
        yield Line2D([], [], color=ROBOT, label="acknowledgement")
    if len(summary.belief):
        yield Line2D([], [], color=FAINT, label="telemetry")


def _robot_keys(summary: FlightSummary) -> Iterable[Artist]:
    if summary.moving:
        yield Line2D([], [], color=ROBOT, linewidth=_WALK_WIDTH, alpha=_WALK_ALPHA, label="moving")
    if summary.returns:
        yield Line2D([], [], color=HOME, linewidth=_WALK_WIDTH, label="way home")
    if any(waypoint.reached_ns is not None for waypoint in summary.waypoints):
        yield _dot(REACHED, "reached")
    if any(waypoint.known_ns is not None for waypoint in summary.waypoints):
        yield _dot("white", "known")


def _dot(color: str, label: str) -> Line2D:
    return Line2D([], [], color=color, marker="o", linestyle="none", markeredgecolor=REACHED, label=label)


def _draw_contact(axes: Axes, summary: FlightSummary) -> None:
    """Shade when nothing can be sent: the upper half for the way up, the lower one for the way down."""
    halves = ((summary.setting.up, 0.5, _OPERATOR_Y), (summary.setting.down, _ROBOT_Y, 0.5))
    for windows, low, high in halves:
        if windows is None:
            continue
        spans = windows.closed(summary.ended_ns, _MOST_WINDOWS)
        if spans is None:
            axes.text(0.5, (low + high) / 2, "too many contact windows to draw", transform=axes.get_yaxis_transform())
            continue
        for begin_ns, end_ns in spans:
            between = (seconds(begin_ns), seconds(end_ns))
            axes.fill_between(between, low, high, color=FAINT, alpha=0.35, linewidth=0, zorder=0)


def _draw_robot(axes: Axes, summary: FlightSummary) -> None:
    """Draw when the robot moved, returned home, reached waypoints, and lost the link."""
    _bars(axes, summary.moving, _ROBOT_Y, ROBOT, _WALK_WIDTH, _WALK_ALPHA)
    ways = [(way.began_ns, summary.ended_ns if way.ended_ns is None else way.ended_ns) for way in summary.returns]
    _bars(axes, ways, _ROBOT_Y, HOME, _WALK_WIDTH, 1.0)
    for way in summary.returns:
        _mark(axes, way.ended_ns, way.ended_known_ns, HOME)
    for waypoint in summary.waypoints:
        _mark(axes, waypoint.reached_ns, waypoint.known_ns, REACHED)
    _bars(axes, summary.link.lost_spans, _UNHEARD_Y, FAILED, 3, 1.0)


def _bars(axes: Axes, spans: Iterable[Span], y: float, color: str, width: float, alpha: float) -> None:
    lines = [[(seconds(begin), y), (seconds(end), y)] for begin, end in spans]
    axes.add_collection(LineCollection(lines, colors=color, linewidths=width, alpha=alpha, zorder=2))


def _mark(axes: Axes, happened_ns: int | None, known_ns: int | None, color: str) -> None:
    """Mark on the robot's line when something happened, and on the operator's when it was known."""
    for time_ns, y, fill in ((happened_ns, _ROBOT_Y, color), (known_ns, _OPERATOR_Y, "white")):
        if time_ns is not None:
            axes.plot(seconds(time_ns), y, "o", color=fill, markeredgecolor=color, markersize=7, zorder=5)


def _draw_telemetry(axes: Axes, summary: FlightSummary) -> None:
    frames = summary.belief.thinned(_MOST_FRAMES)
    ends = np.full(len(frames), _ROBOT_Y), np.full(len(frames), _OPERATOR_Y)
    starts = np.column_stack([frames.time_ns / NS_PER_S, ends[0]])
    stops = np.column_stack([frames.known_ns / NS_PER_S, ends[1]])
    lines = np.stack([starts, stops], axis=1)
    axes.add_collection(LineCollection(list(lines), colors=FAINT, linewidths=0.5, zorder=1))


def _draw_lost(axes: Axes, summary: FlightSummary) -> None:
    """Draw the beginnings of the ways of messages that were not delivered, each with a cross at its end."""
    for way, y, step in ((summary.link.up, _OPERATOR_Y, -_LOST_Y), (summary.link.down, _ROBOT_Y, _LOST_Y)):
        stride = max(1, -(-len(way.missing_ns) // _MOST_LOST))
        times_s = way.missing_ns[::stride] / NS_PER_S
        axes.vlines(times_s, y, y + step, color=FAILED, linewidth=0.6, zorder=4)
        ends = np.full(len(times_s), y + step)
        axes.plot(times_s, ends, "x", color=FAILED, markersize=4, linestyle="none", zorder=4)


def _draw_commands(axes: Axes, summary: FlightSummary) -> None:
    """Draw each command that arrived, from the sending that did, and each acknowledgement."""
    with_heads = len(summary.commands) <= _MOST_ARROWS
    commands: list[Span] = []
    acks: list[Span] = []
    failures: list[Span] = []
    for command in summary.commands:
        if command.received_ns is not None and command.uplink_ns is not None:
            commands.append((command.received_ns - command.uplink_ns, command.received_ns))
        elif _undelivered(command) == "under way":
            # How far it had come when the flight ended is not known, so its line has no head.
            ends_s = [seconds(command.issued_ns), seconds(summary.ended_ns)]
            axes.plot(ends_s, [_OPERATOR_Y, 0.5], "--", color=FAILED, linewidth=1.2)
        for (issued_ns, received_ns), together in groupby(command.acks, lambda ack: (ack.issued_ns, ack.received_ns)):
            last = list(together)[-1]
            (failures if last.stage in _BAD else acks).append((issued_ns, received_ns))
    _arrows(axes, commands, _OPERATOR_Y, _ROBOT_Y, OPERATOR, with_heads)
    _arrows(axes, acks, _ROBOT_Y, _OPERATOR_Y, ROBOT, with_heads)
    _arrows(axes, failures, _ROBOT_Y, _OPERATOR_Y, FAILED, with_heads)


def _arrows(axes: Axes, times: Sequence[Span], from_y: float, to_y: float, color: str, with_heads: bool) -> None:
    if not with_heads:
        lines = [[(seconds(begin), from_y), (seconds(end), to_y)] for begin, end in times]
        axes.add_collection(LineCollection(lines, colors=color, linewidths=0.6, alpha=0.4, zorder=3))
        return
    look = {"arrowstyle": "-|>", "color": color, "linewidth": 1.3, "shrinkA": 0, "shrinkB": 0}
    for begin, end in times:
        ends = ((seconds(end), to_y), (seconds(begin), from_y))
        axes.annotate("", *ends, arrowprops=look, zorder=4, annotation_clip=False)
