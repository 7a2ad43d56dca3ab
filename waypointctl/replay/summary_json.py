"""A flight's summary and its verification as plain data for --json; fields are only ever added."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from typing import TYPE_CHECKING

from waypointctl.replay.return_home import ReturnEnding
from waypointctl.units import seconds

if TYPE_CHECKING:
    from waypointctl.replay.command_summary import CommandSummary
    from waypointctl.replay.link_summary import LinkDirectionSummary
    from waypointctl.replay.return_home import ReturnHome
    from waypointctl.replay.summary import FlightSummary, WaypointSummary
    from waypointctl.replay.track import Track
    from waypointctl.replay.verdict import Verification

Plain = dict[str, object]


def json_text(found: Plain) -> str:
    """Return JSON; a NaN or infinite number is null."""
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
    """Return the verdict with its reasons."""
    first = verification.first_divergence
    return {
        "verdict": str(verification.verdict),
        "steps": verification.steps,
        "first_divergence": None if first is None else asdict(first),
        "reason": verification.reason,
        "checks": list(verification.checks),
        "not_compared": list(verification.not_compared),
    }


def summary_json(summary: FlightSummary, mission: str) -> Plain:
    """Return the summary; times in [s] from mission start, None for what never came.

    Of a command, `issued_s` is its first sending, `uplink_s` is of the sending that arrived first, and `round_trip_s`
    of the sending that the first acknowledgement answers.
    """
    effort, link = summary.effort, summary.link
    return {
        "mission": mission,
        "outcome": summary.outcome,
        "reason": summary.reason,
        "ended_s": seconds(summary.ended_ns),
        "control_steps": summary.steps,
        "waypoints_reached": summary.reached,
        "waypoints_known": summary.known,
        "waypoints_total": len(summary.waypoints),
        "falls": summary.falls,
        "distance_m": effort.distance_m,
        "mean_speed_mps": effort.mean_speed_mps,
        "walking_s": seconds(effort.walking_ns),
        "standing_s": seconds(effort.standing_ns),
        "fallen_s": seconds(effort.fallen_ns),
        "standing_share": effort.standing_share,
        "reward": dict(summary.reward),
        "reward_total": summary.reward_total,
        "states_off_map": summary.states_off_map,
        "frames_off_map": summary.frames_off_map,
        "home": None if summary.home is None else {"x_m": summary.home.x_m, "y_m": summary.home.y_m},
        "returns_home": [_return(each) for each in summary.returns],
        "ended_at": _place(summary.ended_at),
        "believed_at": _place(summary.believed_at),
        "home_distance_m": summary.home_distance_m,
        "waypoints": [_waypoint(waypoint) for waypoint in summary.waypoints],
        "commands": [_command(command) for command in summary.commands],
        "link": {
            "up": _direction(link.up),
            "down": _direction(link.down),
            "lost_on_board": [{"from_s": seconds(begin), "to_s": seconds(end)} for begin, end in link.lost_spans],
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


def _direction(it: LinkDirectionSummary) -> Plain:
    return {
        "lost": it.lost,
        "queue_full": it.queue_full,
        "no_contact": it.no_contact,
        "not_arrived": dict(it.not_arrived),
        "duplicated": it.duplicated,
        "waited": it.waited,
        "longest_wait_s": seconds(it.longest_wait_ns),
    }


def _waypoint(waypoint: WaypointSummary) -> Plain:
    plan = waypoint.planned
    return {
        "name": plan.name,
        "x_m": plan.x_m,
        "y_m": plan.y_m,
        "acceptance": plan.acceptance,
        "tolerance_m": plan.tolerance_m,
        "status": str(waypoint.status),
        "started_s": _seconds(waypoint.started_ns),
        "ended_s": _seconds(waypoint.ended_ns),
        "reached_s": _seconds(waypoint.reached_ns),
        "known_s": _seconds(waypoint.known_ns),
    }


def _command(command: CommandSummary) -> Plain:
    return {
        "id": command.id,
        "command": command.description,
        "issued_s": seconds(command.issued_ns),
        "received_s": _seconds(command.received_ns),
        "acknowledged_s": _seconds(command.acknowledged_ns),
        "ended_s": _seconds(command.ended_ns),
        "end_known_s": _seconds(command.end_known_ns),
        "uplink_s": _seconds(command.uplink_ns),
        "downlink_s": _seconds(command.downlink_ns),
        "round_trip_s": _seconds(command.round_trip_ns),
        "known_stage": str(command.known_stage),
        "on_board": None if command.onboard is None else str(command.onboard),
        "attempts": command.attempts,
        "losses": command.losses,
    }


def _seconds(time_ns: int | None) -> float | None:
    return None if time_ns is None else seconds(time_ns)
