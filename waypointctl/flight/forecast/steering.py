"""What may go wrong where the operator steers: goals that are old."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.flight.forecast.duration import Blocked, round_trip_s, steered_s
from waypointctl.flight.forecast.finding import Finding
from waypointctl.flight.forecast.goals import NEAR_LOOKAHEAD
from waypointctl.flight.forecast.traffic import Traffic
from waypointctl.flight.forecast.way import walks_of
from waypointctl.mission.mission import Mission

_MUCH_SLOWER: Final = 1.5  # times as far as to where a goal counts as reached; what is less is hardly felt


def steering_findings(mission: Mission, speed_mps: float, traffic: Traffic) -> Iterator[Finding]:
    """Yield goals that are older than the robot's way to them, under autonomy heading, continuously."""
    if mission.autonomy != "heading" or mission.operator.steering == "move_and_wait":
        return
    trip_s = round_trip_s(mission, traffic)
    if isinstance(trip_s, Blocked):
        return
    age_s = trip_s + mission.operator.think_s + 1 / mission.operator.update_rate_hz
    walks = walks_of(mission, speed_mps)
    took_s = [steered_s(walk, mission, speed_mps, trip_s) for walk in walks]
    alone_s = sum(walk.way_m for walk in walks) / speed_mps
    slower = sum(took_s) / alone_s if alone_s else 1.0
    reach_m = mission.operator.lookahead_m * (1 - NEAR_LOOKAHEAD)
    if speed_mps * age_s >= _MUCH_SLOWER * reach_m:
        text = (
            f"a goal lies {mission.operator.lookahead_m:g} m ahead of a pose {age_s:.2f} s old, "
            f"and the robot walks {speed_mps * age_s:.1f} m in that time: it stands and waits between goals, and takes "
            f"{slower:.1f} times as long"
        )
        yield Finding("steering", ("operator", "lookahead_m"), text)
