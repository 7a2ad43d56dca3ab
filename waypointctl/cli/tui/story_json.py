"""A flight's story and its proof as plain data for --json; fields are only ever added."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from typing import TYPE_CHECKING

from waypointctl.replay.return_home import ReturnEnding
from waypointctl.units import seconds

if TYPE_CHECKING:
    from waypointctl.replay.link_story import WayStory
    from waypointctl.replay.return_home import ReturnHome
    from waypointctl.replay.story import CommandStory, Story, WaypointStory
    from waypointctl.replay.track import Track
    from waypointctl.replay.verdict import Verification

Plain = dict[str, object]


def json_text(found: Plain) -> str:
    """Return JSON; a number that JSON has no word for, NaN or infinite, is null."""
    return json.dumps(_finite(found), indent=2, allow_nan=False)


def _finite(value: object) -> object:
    match value:
        case float():
            return value if math.isfinite(value) else None
        case dict():
            return {key: _finite(item) for key, item in value.items()}
        case list():
            return [_finite(item) for item in value]
        case _:
            return value


def verification_json(verification: Verification) -> Plain:
    """Return the verdict and what it rests on."""
    first = verification.first_divergence
    return {
        "verdict": str(verification.verdict),
        "steps": verification.steps,
        "first_divergence": None if first is None else asdict(first),
        "reason": verification.reason,
        "checks": list(verification.checks),
        "not_compared": list(verification.not_compared),
    }


def story_json(story: Story, mission: str) -> Plain:
    """Return the story; times in [s] from mission start, None for what never came.

    Of a command, `issued_s` is its first sending, `uplink_s` is of the sending that arrived first, and `round_trip_s`
    of the sending that the first acknowledgement answers.
    """
    effort = story.effort
    return {
        "mission": mission,
        "outcome": story.outcome,
        "reason": story.reason,
        "ended_s": seconds(story.ended_ns),
        "control_steps": story.steps,
        "waypoints_reached": story.reached,
        "waypoints_known": story.learned,
        "waypoints_total": len(story.waypoints),
        "falls": story.falls,
        "distance_m": effort.distance_m,
        "mean_speed_mps": effort.mean_speed_mps,
        "walking_s": seconds(effort.walking_ns),
        "standing_s": seconds(effort.standing_ns),
        "fallen_s": seconds(effort.fallen_ns),
        "standing_share": effort.standing_share,
        "reward": dict(story.reward),
        "reward_total": story.reward_total,
        "states_off_map": story.states_off_map,
        "frames_off_map": story.frames_off_map,
        "home": None if story.home is None else {"x_m": story.home.x_m, "y_m": story.home.y_m},
        "returns_home": [_return(each) for each in story.returns],
        "ended_at": _place(story.ended_at),
        "believed_at": _place(story.believed_at),
        "home_distance_m": story.home_distance_m,
        "waypoints": [_waypoint(waypoint) for waypoint in story.waypoints],
        "commands": [_command(command) for command in story.commands],
        "link": {
            "up": _way(story.link.up),
            "down": _way(story.link.down),
            "lost_on_board": [{"from_s": seconds(begin), "to_s": seconds(end)} for begin, end in story.link.unheard],
        },
    }


def _return(each: ReturnHome) -> Plain:
    return {
        "cause": each.cause,
        "command": each.command_id,
        "began_s": seconds(each.began_ns),
        "began_known_s": _seconds(each.began_known_ns),
        "ending": str(each.ending),
        "reached": each.ending is ReturnEnding.REACHED,
        "ended_s": _seconds(each.ended_ns),
        "ended_known_s": _seconds(each.ended_known_ns),
    }


def _place(track: Track) -> Plain | None:
    """Return the place in a track's only row, and when the robot was there; None of one without a row."""
    if not len(track):
        return None
    return {"x_m": float(track.x_m[0]), "y_m": float(track.y_m[0]), "at_s": seconds(int(track.time_ns[0]))}


def _way(way: WayStory) -> Plain:
    return {
        "lost": way.lost,
        "queue_full": way.queue_full,
        "no_contact": way.no_contact,
        "not_arrived": dict(way.not_arrived),
        "doubled": way.doubled,
        "waited": way.waited,
        "longest_wait_s": seconds(way.longest_wait_ns),
    }


def _waypoint(waypoint: WaypointStory) -> Plain:
    plan = waypoint.planned
    return {
        "name": plan.name,
        "x_m": plan.x_m,
        "y_m": plan.y_m,
        "acceptance": plan.acceptance,
        "tolerance_m": plan.tolerance_m,
        "fate": str(waypoint.fate),
        "started_s": _seconds(waypoint.started_ns),
        "ended_s": _seconds(waypoint.ended_ns),
        "reached_s": _seconds(waypoint.reached_ns),
        "known_s": _seconds(waypoint.learned_ns),
    }


def _command(command: CommandStory) -> Plain:
    return {
        "id": command.id,
        "command": command.what,
        "issued_s": seconds(command.issued_ns),
        "received_s": _seconds(command.received_ns),
        "acknowledged_s": _seconds(command.acknowledged_ns),
        "ended_s": _seconds(command.ended_ns),
        "concluded_s": _seconds(command.concluded_ns),
        "uplink_s": _seconds(command.uplink_ns),
        "downlink_s": _seconds(command.downlink_ns),
        "round_trip_s": _seconds(command.round_trip_ns),
        "known_as": str(command.heard),
        "on_board": None if command.onboard is None else str(command.onboard),
        "attempts": command.attempts,
        "losses": command.losses,
    }


def _seconds(time_ns: int | None) -> float | None:
    return None if time_ns is None else seconds(time_ns)
