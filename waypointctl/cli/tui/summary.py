"""The printed summary of a flight and the verdict of a replay."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from waypointctl.cli.console import console
from waypointctl.cli.tui.formatting import size
from waypointctl.cli.tui.summary_lines import effort_lines, link_lines, whereabouts_lines
from waypointctl.cli.tui.tables import command_table, reward_table, waypoint_table
from waypointctl.display_text import printable, shell_word
from waypointctl.units import seconds

if TYPE_CHECKING:
    from rich.console import Console

    from waypointctl.flight.outcome import FlightResult
    from waypointctl.replay.summary import FlightSummary
    from waypointctl.replay.verdict import Verification

_GOOD: Final = "bold green"
_PART: Final = "bold yellow"
_BAD: Final = "bold red"
_MAP_LINES: Final = 22
_MAP_COLUMNS: Final = 78


def print_flight(summary: FlightSummary, result: FlightResult, wall_s: float, *, stderr: bool) -> None:
    """Print the summary of a flight that has just been flown in `wall_s` of wall time."""
    out = console(stderr=stderr)
    out.print()
    _print_outcome(out, summary)
    _print_tables(out, summary)
    for line in (*effort_lines(summary), *whereabouts_lines(summary), *link_lines(summary.link)):
        _print_line(out, line)
    flown_s = seconds(result.sim_time_ns)
    _print_line(out, f"speed      {flown_s:.2f} s flown in {wall_s:.2f} s, {flown_s / wall_s:.0f} times real time")
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
    from waypointctl.cli.tui.chart import draw_map
    from waypointctl.cli.tui.map_scene import scene_of

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
