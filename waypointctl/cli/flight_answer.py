"""What `waypointctl run` answers to programs: the exit code and the JSON object."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from waypointctl.cli.tui.story_json import Plain, json_text, story_json
from waypointctl.units import seconds

if TYPE_CHECKING:
    from waypointctl.flight.record import Recording
    from waypointctl.replay.story import Story

EXIT_CODES: Final = {"success": 0, "failure": 1, "interrupted": 130}


def answer(mission: str, recording: Recording, story: Story) -> str:
    """Return the JSON object that stands for the flight of a mission, by its name."""
    return f"{json_text(facts(mission, recording, story))}\n"


def facts(mission: str, recording: Recording, story: Story) -> Plain:
    """Return what there is to say of the flight of a mission, by its name; fields are only ever added.

    `waypoints_reached` counts what the operator has heard of; `story` is what `replay --json` has of the log.
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
        "story": story_json(story, mission),
    }
