"""`waypointctl replay`: prove a log, tell its summary, draw it, show it again."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from waypointctl.cli.options import not_negative, positive
from waypointctl.display_text import printable

if TYPE_CHECKING:
    from waypointctl.cli.tui.playback import Playback
    from waypointctl.log.reader import Log
    from waypointctl.replay.summary import FlightSummary
    from waypointctl.replay.verdict import Verification

_PNG: Final = b"\x89PNG"


def replay(
    log: Annotated[Path, typer.Argument(metavar="LOG.mcap", help="The log.", show_default=False)],
    verify: Annotated[bool, typer.Option("--verify", help="Prove it, and tell nothing of the flight.")] = False,
    strict: Annotated[
        bool, typer.Option("--strict", help="Accept only the verdict exact: exit with 1 for less.")
    ] = False,
    png: Annotated[
        Path | None, typer.Option(help="Also draw path, speed and commands into this PNG.", show_default=False)
    ] = None,
    pictures: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER", help="Also write what the robot's camera saw, a PNG a picture.", show_default=False
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the rest goes to stderr.")] = False,
    rate: Annotated[
        float | None,
        typer.Option(callback=positive, help="Only show the flight: this many seconds a second.", show_default=False),
    ] = None,
    start_offset: Annotated[
        float | None, typer.Option(callback=not_negative, help="Show it from this second on.", show_default=False)
    ] = None,
    loop: Annotated[bool, typer.Option("--loop", help="Show it over and over.")] = False,
    start_paused: Annotated[bool, typer.Option("--start-paused", help="Show it when space is pressed.")] = False,
) -> None:
    """Simulate a logged flight again, compare every bit, and tell its summary.

    Everything comes from the log. The verdict is EXACT if the replay writes the same file, byte for byte; EQUIVALENT
    if physics and messages are the same; APPROXIMATE if the physics is, and the rest within rounding: exit with 0.
    Exit with 1 if it diverged or cannot be verified, with --strict for all but EXACT. With --rate, --start-offset,
    --loop or --start-paused the flight is only shown, live on a terminal.
    """
    from waypointctl.cli.pictures import picture_files, write_pictures
    from waypointctl.cli.tui import playback
    from waypointctl.cli.tui.summary import print_summary
    from waypointctl.log.reader import open_log
    from waypointctl.paths import refuse_other_content, refuse_unwritable_file
    from waypointctl.replay.flight_log import mission_name, summary_of
    from waypointctl.replay.summary_json import json_text, summary_json, verification_json

    if rate is not None or start_offset is not None or loop or start_paused:
        if verify or strict or json or png is not None or pictures is not None:
            problem = "the flight is either shown or verified: leave out --verify, --strict, --json, --png, --pictures."
            raise typer.BadParameter(problem)
        _play(open_log(log), playback.Playback(rate or 1.0, start_offset or 0.0, loop, start_paused))
        return
    if png is not None:
        refuse_unwritable_file(png, "the picture")
        refuse_other_content(png, _PNG, "a PNG")
    opened = open_log(log)
    files = None if pictures is None else picture_files(opened, pictures)
    verification = _prove(opened, stderr=json)
    found = verification_json(verification)
    if not verify or png is not None:
        summary = summary_of(opened)
        if not verify:
            print_summary(summary, mission_name(opened), stderr=json)
            found["summary"] = summary_json(summary, mission_name(opened))
        if png is not None:
            _draw(summary, opened, verification, png)
    if pictures is not None and files is not None:
        write_pictures(files, pictures)
    if json:
        sys.stdout.write(f"{json_text(found)}\n")
    accepted = verification.verdict == "exact" if strict else verification.verdict.is_proof
    raise typer.Exit(0 if accepted else 1)


def _play(log: Log, playback: Playback) -> None:
    from waypointctl.cli.interruption import interruption
    from waypointctl.cli.tui.playback import play

    with interruption() as interrupted:
        play(log, playback, interrupted)
        if interrupted():
            raise typer.Exit(130)


def _prove(log: Log, *, stderr: bool) -> Verification:
    from waypointctl.cli.console import console, is_live
    from waypointctl.cli.tui.summary import print_verdict
    from waypointctl.replay.verify import verify_log

    people = console(stderr=True)
    if is_live(people):
        with people.status("simulating the flight again"):
            verification = verify_log(log)
    else:
        verification = verify_log(log)
    print_verdict(verification, stderr=stderr)
    return verification


def _draw(summary: FlightSummary, log: Log, verification: Verification, png: Path) -> None:
    from waypointctl.paths import write_whole
    from waypointctl.replay.flight_log import mission_name
    from waypointctl.replay.picture.page import draw

    proof = f"replay {verification.verdict}, {verification.steps} control steps"
    picture = draw(summary, mission_name(log), proof, is_exact=verification.verdict == "exact")
    write_whole(png, picture, "the picture")
    typer.echo(f"drawn into {printable(png)}", err=True)
