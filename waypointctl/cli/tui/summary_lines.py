"""The lines below a flight's tables: distance and time, returns home, where the robot ended, the link."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from waypointctl.cli.tui.formatting import at
from waypointctl.display_text import printable
from waypointctl.log.messages import EventKind
from waypointctl.replay.track import FARTHEST_M
from waypointctl.units import NS_PER_S, seconds

if TYPE_CHECKING:
    from waypointctl.replay.link_summary import LinkDirectionSummary, LinkSummary
    from waypointctl.replay.return_home import ReturnHome
    from waypointctl.replay.summary import FlightSummary
    from waypointctl.replay.track import Track


def whereabouts_lines(summary: FlightSummary) -> list[str]:
    """Return a line for each return home, and one for where the robot ended; nothing of a flight without a state."""
    lines = [f"return     {printable(str(each))}; {_known(each)}" for each in summary.returns]
    end, believed = summary.ended_at, summary.believed_at
    if not len(end):
        return lines
    home = "" if summary.home_distance_m is None else f", {summary.home_distance_m:.2f} m from home"
    last = "no position known to the operator"
    if len(believed):
        last = f"last known to the operator: {_place(believed)}, sampled at {at(int(believed.time_ns[0]))}"
    return [*lines, f"ended      at {_place(end)}{home}; {last}"]


def _known(each: ReturnHome) -> str:
    if each.ended_known_ns is not None:
        return f"known to the operator at {at(each.ended_known_ns)}"
    if each.began_known_ns is not None:
        return f"its start was known to the operator at {at(each.began_known_ns)}"
    return "not known to the operator"


def _place(track: Track) -> str:
    return f"({float(track.x_m[0]):.2f}, {float(track.y_m[0]):.2f}) m"


def effort_lines(summary: FlightSummary) -> list[str]:
    """Return how far, how fast, and how the time was spent."""
    effort = summary.effort
    speed = "" if effort.mean_speed_mps is None else f", {effort.mean_speed_mps:.2f} m/s while walking"
    spent = f"{effort.walking_ns / 1e9:.2f} s walking, {effort.standing_ns / 1e9:.2f} s standing"
    if effort.standing_share is not None:
        spent += f" ({effort.standing_share:.0%})"
    if effort.fallen_ns:
        spent += f", {effort.fallen_ns / 1e9:.2f} s fallen"
    lines = [f"distance   {effort.distance_m:.2f} m{speed}", f"time       {spent}"]
    if summary.falls:
        falls = (at(event.time_ns) for event in summary.events if event.kind is EventKind.FALL)
        lines.append(f"fell       at {', '.join(falls)}")
    if off_map := _off_map(summary):
        lines.append(f"left out   {off_map}: not finite, or beyond {FARTHEST_M:,.0f} m")
    return lines


def _off_map(summary: FlightSummary) -> str:
    """Return the counts of values that are off the map, as text; empty for a log that was not altered."""
    waypoints = sum(not waypoint.is_on_map for waypoint in summary.waypoints)
    counts = ((summary.states_off_map, "state"), (summary.frames_off_map, "telemetry frame"), (waypoints, "waypoint"))
    return ", ".join(f"{count} {what}{'' if count == 1 else 's'}" for count, what in counts if count)


# Message kinds as text.
_KINDS: Final = {
    "ack": "acknowledgement",
    "telemetry": "telemetry frame",
    "bodyframe": "state",
    "controlframe": "action",
}


def link_lines(link: LinkSummary) -> list[str]:
    """Return a line for each way on which messages were lost, duplicated, dropped or queued."""
    ways = (("link up    ", link.up), ("link down  ", link.down))
    return [f"{label}{', '.join(_direction(way))}" for label, way in ways if way]


def _direction(way: LinkDirectionSummary) -> Iterator[str]:
    missing = [f"{way.lost} lost"] if way.lost else []
    missing += [f"{way.queue_full} dropped because the queue was full"] if way.queue_full else []
    missing += [f"{way.no_contact} dropped because no contact was left"] if way.no_contact else []
    if missing:
        yield f"{'; '.join(missing)} ({', '.join(_several(kind, count) for kind, count in way.not_arrived)})"
    if way.duplicated:
        yield f"{way.duplicated} duplicated"
    if way.waited:
        yield f"{way.waited} queued, for at most {_wait(way.longest_wait_ns)}"


def _wait(time_ns: int) -> str:
    """Return a wait; one that is short with two figures, however short."""
    return at(time_ns) if time_ns >= NS_PER_S // 10 else f"{seconds(time_ns) * 1e3:.2g} ms"


def _several(kind: str, count: int) -> str:
    return f"{count} {_KINDS.get(kind, printable(kind))}{'' if count == 1 else 's'}"
