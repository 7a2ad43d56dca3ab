"""What `waypointctl run` answers to programs: the exit code and the JSON object."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from waypointctl.replay.summary_json import Plain, json_text, summary_json
from waypointctl.units import seconds

if TYPE_CHECKING:
    from waypointctl.flight.record import Recording
    from waypointctl.replay.summary import FlightSummary

EXIT_CODES: Final = {"success": 0, "failure": 1, "interrupted": 130}


def answer(mission: str, recording: Recording, summary: FlightSummary) -> str:
    """Return the JSON object that stands for the flight of a mission, by its name."""
    return f"{json_text(facts(mission, recording, summary))}\n"


def facts(mission: str, recording: Recording, summary: FlightSummary) -> Plain:
    """Return what there is to say of the flight of a mission, by its name; fields are only ever added.

    `waypoints_reached` counts what the operator has heard of; `summary` is what `replay --json` has of the log.
    """
    result = recording.result
    return {
        "mission": mission,
        "outcome": result.outcome,
        "reason": result.reason,
        "waypoints_reached": result.waypoints_reached,
        "waypoints_total": result.waypoints_total,
        "sim_time_s": seconds(result.sim_time_ns),
        "seed": recording.seed,
        "log": str(recording.path),
        "log_sha256": recording.sha256,
        "pictures": recording.pictures,
        "summary": summary_json(summary, mission),
    }
