"""What may go wrong where the operator steers: legs whose time is out between goals, and goals that are old."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.mission.mission import Leg, Mission
from waypointctl.ops.forecast.duration import Blocked, round_trip_s, steered_moves, steered_s
from waypointctl.ops.forecast.finding import NOT_COMPLETED, Finding
from waypointctl.ops.forecast.goals import NEAR_CARROT
from waypointctl.ops.forecast.traffic import Traffic, go_to_bytes
from waypointctl.ops.forecast.way import walks_of
from waypointctl.units import ns, seconds

_MUCH_SLOWER: Final = 1.5  # times as far as to where a goal counts as reached; what is less is hardly felt


def steering_findings(mission: Mission, speed_mps: float, traffic: Traffic) -> Iterator[Finding]:
    """Yield what may go wrong under autonomy heading. A leg's time is the robot's, from its first goal's start on."""
    if mission.autonomy != "heading":
        return
    if mission.operator.steering == "move_and_wait":
        yield from _move_and_wait(mission, speed_mps, traffic)
    else:
        yield from _continuous(mission, speed_mps, traffic)


def _move_and_wait(mission: Mission, speed_mps: float, traffic: Traffic) -> Iterator[Finding]:
    """Yield the legs that are given up before the last of their goals is sent."""
    walks, legs = walks_of(mission, speed_mps), mission.legs()
    spent_s = [walk.way_m / speed_mps if walk.duration_s is None else walk.duration_s for walk in walks]
    counts, heard = steered_moves(mission, walks, spent_s, traffic)
    think_ns = ns(mission.operator.think_s)
    first, sent_ns = 0, 0  # of a leg's goals: its place, and when it is sent
    for walk, count in zip(walks, counts, strict=True):
        # The time is looked at when a goal is over, and the waypoint itself is the last goal.
        last, end = (heard[place] if place < len(heard) else None for place in (first + count - 2, first + count - 1))
        begins_ns = traffic.arrives_up_ns(sent_ns, go_to_bytes(walk.waypoint))
        first += count
        if walk.duration_s is not None and count > 1 and begins_ns is not None and isinstance(last, int):
            needed_s = seconds(last - traffic.down.delay(last) - begins_ns)
            leg = legs[walk.waypoint.index]
            if needed_s > leg.timeout_s:
                text = (
                    f"{leg.name} takes {count} short-range goals: the robot is on its way for {needed_s:.1f} s until "
                    f"the last but one is reached, waiting included, and the leg has {leg.timeout_s:g} s; give it "
                    "more, or a longer operator.carrot"
                )
                yield _timeout(leg, text)
        if not isinstance(end, int):
            return
        sent_ns = end + think_ns


def _continuous(mission: Mission, speed_mps: float, traffic: Traffic) -> Iterator[Finding]:
    """Yield goals that are older than the robot's way to them, and legs that take too long for it."""
    trip_s = round_trip_s(mission, traffic)
    if isinstance(trip_s, Blocked):
        return
    age_s = trip_s + mission.operator.think_s + 1 / mission.operator.update_rate_hz
    walks = walks_of(mission, speed_mps)
    took_s = [steered_s(walk, mission, speed_mps, trip_s) for walk in walks]
    alone_s = sum(walk.way_m for walk in walks) / speed_mps
    slower = sum(took_s) / alone_s if alone_s else 1.0
    reach_m = mission.operator.carrot_m * (1 - NEAR_CARROT)
    if speed_mps * age_s >= _MUCH_SLOWER * reach_m:
        text = (
            f"goals lie {mission.operator.carrot_m:g} m ahead of a pose that is {age_s:.2f} s old when the next comes, "
            f"and the robot walks {speed_mps * age_s:.1f} m in that time: it stands and waits between goals, and takes "
            f"{slower:.1f} times as long"
        )
        yield Finding("steering", ("operator", "carrot_m"), text)
    legs = mission.legs()
    for walk, needed_s in zip(walks, took_s, strict=True):
        leg = legs[walk.waypoint.index]
        if walk.duration_s is not None and needed_s > leg.timeout_s:
            text = f"{leg.name} takes {needed_s:.1f} s steered from poses that old, and the leg has {leg.timeout_s:g} s"
            yield _timeout(leg, text)


def _timeout(leg: Leg, text: str) -> Finding:
    return Finding("timeout", ("waypoints", leg.at, "timeout_s"), text, NOT_COMPLETED)
