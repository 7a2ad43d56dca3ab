"""The printed summary of a flight and the verdict of a replay."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from rich.console import Console

from waypointctl.cli.console import console
from waypointctl.cli.tui.formatting import MESSAGE_KINDS, at, size
from waypointctl.cli.tui.tables import command_table, reward_table, waypoint_table
from waypointctl.display_text import printable, shell_word
from waypointctl.flight.outcome import FlightResult
from waypointctl.log.messages import DeliveryOutcome, EventKind
from waypointctl.replay.legs import ReturnHome
from waypointctl.replay.link_summary import LinkDirectionSummary, LinkSummary
from waypointctl.replay.summary import FlightSummary
from waypointctl.replay.track import FARTHEST_M, Track
from waypointctl.replay.verify import Verification
from waypointctl.units import NS_PER_S, seconds

_GOOD: Final = "bold green"
_PART: Final = "bold yellow"
_BAD: Final = "bold red"
_MAP_LINES: Final = 22
_MAP_COLUMNS: Final = 78
_OUTCOMES: Final = {
    DeliveryOutcome.LOST: "lost",
    DeliveryOutcome.QUEUE_FULL: "dropped because the queue was full",
    DeliveryOutcome.NO_CONTACT: "dropped because no contact was left",
}


def print_flight(summary: FlightSummary, result: FlightResult, wall_s: float, *, stderr: bool) -> None:
    """Print the summary of a flight that has just been flown in `wall_s` of wall time."""
    out = console(stderr=stderr)
    out.print()
    _print_outcome(out, summary)
    _print_tables(out, summary)
    for line in (*effort_lines(summary), *whereabouts_lines(summary), *link_lines(summary.link)):
        _print_line(out, line)
    flown_s = seconds(result.sim_time_ns)
    rate = f"{flown_s / wall_s:.0f} times real time"
    _print_line(out, f"wall time  {wall_s:.2f} s for {flown_s:.2f} s of simulation, {rate}")
    out.print(f"seed       {result.seed}")
    if result.log is None:
        return
    if result.pictures:
        log = shell_word(result.log)
        _print_line(out, f"pictures   {result.pictures}: waypointctl replay {log} --pictures FOLDER")
    _print_line(out, f"log        {printable(result.log)} ({size(result.log.stat().st_size)})")
    _print_line(out, f"sha256     {result.log_sha256}")


def print_verdict(verification: Verification, *, stderr: bool) -> None:
    """Print the verdict, what was compared, and the first divergence, if any."""
    out = console(stderr=stderr)
    verdict = verification.verdict
    is_same = verdict.is_reproduced
    style = _GOOD if is_same and not verification.not_compared else _PART if is_same else _BAD
    _print_line(out, printable(f"{verdict.upper()}: {verification.reason}"), style=style)
    for check in verification.checks:
        _print_line(out, f"  {check}")
    for line in verification.not_compared:
        _print_line(out, printable(f"  not compared: {line}"))
    first = verification.first_divergence
    if first is not None:
        step = f"step {first.step}, " if first.step >= 0 else ""
        where = f"{step}{seconds(first.time_ns):.3f} s, {first.topic}, {first.component}"
        for line in (where, f"logged    {first.logged}", f"replayed  {first.replayed}"):
            _print_line(out, f"  {printable(line)}")
    out.print()


def print_summary(summary: FlightSummary, title: str, *, stderr: bool) -> None:
    """Print the summary of a logged flight."""
    from waypointctl.cli.tui.chart import draw_map, scene_of

    out = console(stderr=stderr)
    _print_line(out, printable(title), style="bold")
    _print_outcome(out, summary)
    out.print()
    scene = scene_of(summary, _MAP_COLUMNS * 50)
    ascii_only = not out.encoding.lower().startswith("utf")
    *rows, legend = draw_map(scene, min(out.width, _MAP_COLUMNS), _MAP_LINES, ascii_only=ascii_only)
    drawn = [line for line, row in enumerate(rows) if row.plain.strip()]
    for row in (*rows[min(drawn, default=0) : max(drawn, default=-1) + 1], legend):
        out.print(row, crop=True)
    _print_tables(out, summary)
    out.print(reward_table(summary))
    out.print()
    for line in (*effort_lines(summary), *whereabouts_lines(summary), *link_lines(summary.link)):
        _print_line(out, line)


def _print_line(out: Console, text: str, style: str = "") -> None:
    """Print a line: on a terminal broken between words, elsewhere whole, for programs that look for it."""
    out.print(text, style=style, soft_wrap=not out.is_terminal)


def _print_outcome(out: Console, summary: FlightSummary) -> None:
    style = _GOOD if summary.outcome == "success" else _BAD
    _print_line(out, printable(summary.headline), style=style)


def _print_tables(out: Console, summary: FlightSummary) -> None:
    out.print()
    out.print(waypoint_table(summary))
    out.print()
    out.print(command_table(summary))
    out.print()


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
    speed = "" if effort.mean_speed_mps is None else f", {effort.mean_speed_mps:.2f} m/s mean while moving"
    spent = f"{effort.moving_ns / 1e9:.2f} s moving, {effort.stopped_ns / 1e9:.2f} s stopped"
    if effort.stopped_share is not None:
        spent += f" ({effort.stopped_share:.0%})"
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


def link_lines(link: LinkSummary) -> list[str]:
    """Return a line for each way on which messages were lost, duplicated, dropped or queued."""
    ways = (("link up    ", link.up), ("link down  ", link.down))
    return [f"{label}{', '.join(_direction(way))}" for label, way in ways if way]


def _direction(way: LinkDirectionSummary) -> Iterator[str]:
    counts = ((way.count(outcome), text) for outcome, text in _OUTCOMES.items())
    missing = [f"{count} {text}" for count, text in counts if count]
    if missing:
        kinds = (_several(kind, count) for kind, count in way.not_arrived.items())
        yield f"{'; '.join(missing)} ({', '.join(kinds)})"
    if duplicated := way.count(DeliveryOutcome.DUPLICATED):
        yield f"{duplicated} duplicated"
    if way.waited:
        yield f"{way.waited} queued, for at most {_wait(way.longest_wait_ns)}"


def _wait(time_ns: int) -> str:
    """Return a wait; one that is short with two figures, however short."""
    return at(time_ns) if time_ns >= NS_PER_S // 10 else f"{seconds(time_ns) * 1e3:.2g} ms"


def _several(kind: str, count: int) -> str:
    return f"{count} {MESSAGE_KINDS.get(kind, printable(kind))}{'' if count == 1 else 's'}"
