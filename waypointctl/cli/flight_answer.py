"""What `waypointctl run` answers: the summary for people, the JSON object for programs, the exit code."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Final

from waypointctl.replay.summary_json import Plain, json_text, summary_json
from waypointctl.units import seconds

if TYPE_CHECKING:
    from waypointctl.flight.outcome import FlightResult
    from waypointctl.replay.summary import FlightSummary

EXIT_CODES: Final = {"success": 0, "failure": 1, "interrupted": 130}


def report_flight(
    mission: str, result: FlightResult, summary: FlightSummary, wall_s: float | None, *, json: bool
) -> int:
    """Print the outcome of a flight, with the JSON object if `--json` is given; return the exit code.

    Args:
        mission: its name.
        result: of the flight.
        summary: of the flight.
        wall_s: the wall time that it took; None for one that was flown before, of which only the object is printed.
        json: print the object on stdout, and the rest on stderr.
    """
    from waypointctl.cli.pictures import say_missing
    from waypointctl.cli.tui.summary import print_flight

    if wall_s is not None:
        say_missing(result)
        print_flight(summary, result, wall_s, stderr=json)
    if json:
        sys.stdout.write(f"{json_text(facts(mission, result, summary))}\n")
    return EXIT_CODES.get(summary.outcome, 1)


def facts(mission: str, result: FlightResult, summary: FlightSummary) -> Plain:
    """Return the facts of a mission's flight; fields are only ever added.

    `waypoints_reached` counts those known to the operator; `summary` is what `replay --json` has of the log.
    """
    return {
        "mission": mission,
        "outcome": result.outcome,
        "reason": result.reason,
        "waypoints_reached": result.waypoints_reached,
        "waypoints_total": result.waypoints_total,
        "sim_time_s": seconds(result.sim_time_ns),
        "seed": result.seed,
        "log": str(result.log),
        "log_sha256": result.log_sha256,
        "pictures": result.pictures,
        "summary": summary_json(summary, mission),
    }
