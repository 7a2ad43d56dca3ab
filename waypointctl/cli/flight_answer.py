"""What `waypointctl run` answers to programs: the exit code and the JSON object."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from waypointctl.replay.summary_json import Plain, json_text, summary_json
from waypointctl.units import seconds

if TYPE_CHECKING:
    from waypointctl.flight.outcome import FlightResult
    from waypointctl.replay.summary import FlightSummary

EXIT_CODES: Final = {"success": 0, "failure": 1, "interrupted": 130}


def answer(mission: str, result: FlightResult, summary: FlightSummary) -> str:
    """Return the JSON object that stands for the flight of a mission, by its name."""
    return f"{json_text(facts(mission, result, summary))}\n"


def facts(mission: str, result: FlightResult, summary: FlightSummary) -> Plain:
    """Return what there is to say of the flight of a mission, by its name; fields are only ever added.

    `waypoints_reached` counts what the operator has heard of; `summary` is what `replay --json` has of the log.
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
