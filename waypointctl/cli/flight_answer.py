"""What `waypointctl run` answers to programs: the exit code and the JSON object."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, Final

from waypointctl.units import seconds

if TYPE_CHECKING:
    from waypointctl.ops.record import Recording

EXIT_CODES: Final = {"success": 0, "failure": 1, "interrupted": 130}


def answer(mission: str, recording: Recording) -> str:
    """Return the JSON object that stands for the flight of a mission, by its name."""
    return f"{json.dumps(facts(mission, recording), indent=2)}\n"


def facts(mission: str, recording: Recording) -> dict[str, Any]:
    """Return what there is to say of the flight of a mission, by its name."""
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
    }
