"""Where a flight led: the ways home, and where the robot was in the end; truth and belief apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

from waypointctl.cli.tui.formatting import at
from waypointctl.display_text import printable

if TYPE_CHECKING:
    from waypointctl.replay.return_home import ReturnHome
    from waypointctl.replay.summary import FlightSummary
    from waypointctl.replay.track import Track


def whereabouts_lines(summary: FlightSummary) -> list[str]:
    """Return a line for each way home, and one for where the robot ended; nothing of a flight without a state."""
    lines = [f"way home   {printable(str(each))}; {_known(each)}" for each in summary.returns]
    end, believed = summary.ended_at, summary.believed_at
    if not len(end):
        return lines
    home = "" if summary.home_distance_m is None else f", {summary.home_distance_m:.2f} m from home"
    last = "the operator has heard of no place"
    if len(believed):
        last = f"the operator's last frame, sampled at {at(int(believed.time_ns[0]))}, has {_place(believed)}"
    return [*lines, f"ended      at {_place(end)}{home}; {last}"]


def _known(each: ReturnHome) -> str:
    if each.ended_known_ns is not None:
        return f"known to the operator at {at(each.ended_known_ns)}"
    if each.began_known_ns is not None:
        return f"the operator has heard of its beginning, at {at(each.began_known_ns)}"
    return "the operator has not heard of it"


def _place(track: Track) -> str:
    return f"({float(track.x_m[0]):.2f}, {float(track.y_m[0]):.2f}) m"
