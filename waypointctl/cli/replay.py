"""`waypointctl replay`: verify a log, summarize, draw or show its flight."""

from __future__ import annotations

import math
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from waypointctl.cli.options import PluginFiles, number_to, parsed, positive
from waypointctl.display_text import printable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from waypointctl.cli.tui.playback import Playback
    from waypointctl.replay.flight_log import FlightLog
    from waypointctl.replay.verify import Verification


def replay(
    log: Annotated[Path, typer.Argument(metavar="LOG.mcap", help="The log.")],
    verify: Annotated[bool, typer.Option("--verify", help="Verify only; print no summary of the flight.")] = False,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with 1 for any verdict but EXACT.")] = False,
    png: Annotated[Path | None, typer.Option(help="Also draw path, speed and commands to this PNG.")] = None,
    pictures: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="Also write the pictures of the robot's camera, as PNG files.")
    ] = None,
    plugin: PluginFiles = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the rest goes to stderr.")] = False,
    rate: Annotated[
        float | None, parsed("X", positive, "Only show the flight, at X simulated seconds per second.")
    ] = None,
    start_offset: Annotated[
        float | None, parsed("S", number_to(math.inf), "Only show the flight, from this second on.")
    ] = None,
    loop: Annotated[bool, typer.Option("--loop", help="Only show the flight, repeated until interrupted.")] = False,
    start_paused: Annotated[
        bool, typer.Option("--start-paused", help="Only show the flight, paused until space is pressed.")
    ] = False,
) -> None:
    """Simulate a logged flight again and compare it with the log.

    A summary of the flight is printed.

    The replay needs the log and the plugins that it names, if it names any. The verdict is EXACT if the replay writes
    the same file, byte for byte; EQUIVALENT if physics and messages are the same, bit for bit; APPROXIMATE if the
    physics is the same, bit for bit, and the rest within rounding. These exit with 0. DIVERGED and
    UNVERIFIABLE exit with 1, with --strict every verdict but EXACT. With --rate, --start-offset, --loop or
    --start-paused the flight is not verified, only shown on the terminal.
    """
    from waypointctl.cli.tui.playback import Playback
    from waypointctl.replay.flight_log import FlightLog

    if rate is not None or start_offset is not None or loop or start_paused:
        if verify or strict or json or plugin or png is not None or pictures is not None:
            raise typer.BadParameter(
                "--rate, --start-offset, --loop and --start-paused cannot be used with --verify, --strict, --json, "
                "--plugin, --png or --pictures."
            )
        _play(FlightLog.open(log), Playback(rate or 1.0, start_offset or 0.0, loop, start_paused))
        return
    verification = _replay(log, plugin or (), summary=not verify, png=png, pictures=pictures, json=json)
    accepted = verification.verdict == "exact" if strict else verification.verdict.is_reproduced
    raise typer.Exit(0 if accepted else 1)


def _replay(
    path: Path, plugins: Sequence[Path], *, summary: bool, png: Path | None, pictures: Path | None, json: bool
) -> Verification:
    """Verify a log and write the outputs; refuse files that cannot be written before the replay starts."""
    from waypointctl.cli.flight_view import json_text
    from waypointctl.cli.log_place import picture_files, write_pictures
    from waypointctl.cli.tui.summary import print_summary
    from waypointctl.paths import PNG, refuse_other_content, refuse_unwritable_file
    from waypointctl.replay.flight_log import FlightLog
    from waypointctl.replay.summary import summary_json
    from waypointctl.replay.verify import verification_json

    if png is not None:
        refuse_unwritable_file(png, "the picture")
        refuse_other_content(png, PNG, "a PNG")
    log = FlightLog.open(path)
    files = None if pictures is None else picture_files(log, pictures)
    verification = _verify(log, plugins, stderr=json)
    found = verification_json(verification)
    if summary:
        print_summary(log.summary, log.mission_name, stderr=json)
        found["summary"] = summary_json(log.summary, log.mission_name)
    if png is not None:
        _draw(log, verification, png)
    if pictures is not None and files is not None:
        write_pictures(files, pictures, log)
    if json:
        sys.stdout.write(f"{json_text(found)}\n")
    return verification


def _play(log: FlightLog, playback: Playback) -> None:
    from waypointctl.cli.program import interruption
    from waypointctl.cli.tui.playback import play

    with interruption() as interrupted:
        play(log, playback, interrupted)
        if interrupted():
            raise typer.Exit(130)


def _verify(log: FlightLog, plugins: Sequence[Path], *, stderr: bool) -> Verification:
    from waypointctl.cli.console import console, is_live
    from waypointctl.cli.tui.summary import print_verdict
    from waypointctl.replay.verify import verify_log
    from waypointctl.task.plugins import load_plugins

    people, executed = console(stderr=True), load_plugins(plugins)
    with people.status("simulating the flight") if is_live(people) else nullcontext():
        verification = verify_log(log, executed)
    print_verdict(verification, stderr=stderr)
    return verification


def _draw(log: FlightLog, verification: Verification, png: Path) -> None:
    from waypointctl.paths import write_whole
    from waypointctl.replay.picture.page import draw

    verdict = f"replay {verification.verdict}, {verification.steps} control steps"
    picture = draw(log.summary, log.mission_name, verdict, is_exact=verification.verdict == "exact")
    write_whole(png, picture, "the picture")
    typer.echo(f"written: {printable(png)}", err=True)
