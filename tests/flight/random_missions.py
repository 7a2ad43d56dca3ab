"""Missions drawn at random: rules on board, faults of the link, ways home, holds and schedules, under each autonomy.

Flights are short: waypoints are near, times are short, and where a wait is long nothing moves in it.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from pydantic import ValidationError

from tests.flight.flight_oracle import faults
from waypointctl.flight.fly import fly
from waypointctl.flight.outcome import FlightResult
from waypointctl.log.messages import Event, EventKind, Message
from waypointctl.mission.files import MissionFile, parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.verify import Verdict, verify

Content: TypeAlias = dict[str, Any]

_AUTONOMIES = ("mission",) * 4 + ("waypoint",) * 3 + ("short_range_goal",) * 3 + ("joint",)


@dataclass(frozen=True, slots=True)
class Judged:
    """A flight and what is wrong with it.

    Attributes:
        result: how it ended.
        faults: what is wrong, a line each.
        went_home: whether the robot was on a way home.
    """

    result: FlightResult
    faults: tuple[str, ...]
    went_home: bool


def judged(seed: int, policy: LoadedPolicy, folder: Path, *, proved: bool = True) -> Judged:
    """Fly the mission of a seed, judge its messages and, if it is to be proved, its log."""
    path = folder / f"{seed}.mcap"
    source = mission_of_seed(seed).model_dump_json(exclude_unset=True).encode()
    mission_file = MissionFile(parse_mission(source, str(path)), source, path)
    messages: list[Message] = []
    result = fly(mission_file, policy, messages.append, log=path, pictures=proved)
    found = faults(mission_file.mission, result, messages)
    if proved and (verification := verify(path)).verdict is not Verdict.EXACT:
        found.append(f"{verification.verdict}: {verification.reason}")
    path.unlink()
    went_home = any(isinstance(one, Event) and one.kind is EventKind.RETURN_STARTED for one in messages)
    return Judged(result, tuple(found), went_home)


def mission_of_seed(seed: int) -> Mission:
    """Return the mission of a seed; one that could never be flown (a cancel of what is not sent) is drawn again."""
    rng = random.Random(seed)
    while True:
        try:
            return Mission.model_validate(_content(rng, seed))
        except ValidationError:
            continue


def _content(rng: random.Random, seed: int) -> Content:
    autonomy = rng.choice(_AUTONOMIES)
    joint = autonomy == "joint"
    waypoints = [_waypoint(rng) for _ in range(rng.randint(1, 3))]
    content: Content = {
        "name": f"random-{seed}",
        "policy": "policies/ant-waypoint",
        "seed": rng.randrange(1 << 30),
        "autonomy": autonomy,
        "waypoints": waypoints,
        "on_failure": {
            "retry": rng.choice((0, 0, 1)),
            "then": rng.choice(("abort", "skip", "hold", "return_home", "return_home")),
        },
        "onboard": _onboard(rng),
        "operator": _operator(rng, len(waypoints)),
        "commands": {
            "retries": rng.choice((0, 1, 1, 2, 4)),
            "acknowledged": rng.random() < 0.9,
            "margin_s": rng.choice((0.2, 1.0)),
        },
        "link": {way: _way(rng, joint=joint, steered=autonomy == "short_range_goal") for way in ("up", "down")},
        "telemetry": {"rate_hz": rng.choice((1.0, 2.0, 5.0)), "beacon_s": rng.choice((5.0, 30.0))},
        "schedule": [] if rng.random() < 0.5 else [_scheduled(rng) for _ in range(rng.randint(1, 3))],
        "expect": {"reached": rng.choice(("all", "all", 0, 1))},
    }
    if rng.random() < 0.1:
        content["expect"]["max_time_s"] = rng.uniform(5.0, 60.0)
    return content


def _waypoint(rng: random.Random) -> Content:
    if rng.random() < 0.25:  # out of reach in its time
        return {"position_m": [rng.uniform(20, 30), rng.uniform(-5, 5)], "timeout_s": rng.uniform(0.5, 3.0)}
    waypoint: Content = {
        "position_m": [rng.uniform(-4, 4), rng.uniform(-4, 4)],
        "timeout_s": rng.choice((3.0, 8.0, 8.0)),
        "tolerance_m": rng.choice((0.3, 0.5, 1.0)),
    }
    if rng.random() < 0.3:
        waypoint["hold_s"] = rng.choice((0.5, 3.0, 15.0, 120.0, 4000.0))
    if rng.random() < 0.2:
        waypoint["observe"] = True
    return waypoint


def _onboard(rng: random.Random) -> Content:
    onboard: Content = {"home": {"tolerance_m": rng.choice((0.5, 1.0)), "timeout_s": rng.choice((2.0, 15.0, 15.0))}}
    if rng.random() < 0.4:
        after_s = rng.choice((1.0, 3.0, 8.0, 40.0))
        onboard["link_loss"] = {"after_s": after_s, "do": rng.choice(("finish", "hold", "return_home"))}
    if rng.random() < 0.3:
        area = {"center_m": [rng.uniform(-2, 2), rng.uniform(-2, 2)], "radius_m": rng.uniform(0.3, 1.0)}
        onboard["geofence"] = {"keep_out": [area], "do": rng.choice(("hold", "return_home", "abort"))}
    if rng.random() < 0.2:
        onboard["stuck"] = {"within_m": 0.3, "for_s": 1.0}
    if rng.random() < 0.1:
        onboard["stopped_tolerance_m"] = 1.0
    return onboard


def _operator(rng: random.Random, count: int) -> Content:
    operator: Content = {
        "think_s": rng.choice((0.0, 0.0, 0.5, 3.0, 300.0)),
        "steering": rng.choice(("move_and_wait", "continuous")),
        "lookahead_m": rng.choice((1.0, 3.0)),
        "update_rate_hz": rng.choice((0.5, 1.0, 2.0)),
    }
    if operator["steering"] == "continuous":
        operator["think_s"] = rng.choice((0.0, 0.5))
    if rng.random() < 0.4:
        operator["heartbeat_s"] = rng.choice((0.5, 2.0, 10.0))
    if rng.random() < 0.15:
        operator["released"] = rng.randint(0, count)
    return operator


def _way(rng: random.Random, *, joint: bool, steered: bool) -> Content:
    if joint and rng.random() < 0.7:
        return {"delay_s": rng.choice((0.0, 0.0, 0.02))}
    way: Content = {"delay_s": rng.choice((0.0, 0.2, 1.28, 2.5))}
    if rng.random() < 0.5:
        way["jitter_s"] = rng.uniform(0.0, way["delay_s"])
        way["keep_order"] = rng.random() < 0.5
    fault = rng.random()
    if fault < 0.35:
        way["loss"] = rng.choice((0.05, 0.2, 0.45, 0.7))
    elif fault < 0.55:
        way["loss"] = {"p": rng.uniform(0.02, 0.3), "r": rng.uniform(0.1, 0.6)}
    elif fault < 0.57:
        way["loss"] = rng.choice((1.0, {"p": 0.05, "r": 0.0}))
    if rng.random() < 0.2:
        way["duplicate"] = rng.choice((0.1, 1.0))
    if rng.random() < 0.2:
        opens_s, open_s = rng.uniform(0.0, 3.0), rng.uniform(2.0, 10.0)
        way["windows"] = [{"from_s": opens_s, "to_s": opens_s + open_s}]
        if rng.random() < 0.8:
            way["windows_period_s"] = opens_s + open_s + rng.choice((2.0, 30.0, 30.0 if steered else 1800.0))
    if rng.random() < 0.1:
        way["rate_bps"] = rng.choice((4_000.0, 64_000.0))
    return way


def _scheduled(rng: random.Random) -> Content:
    do = rng.choice(
        ("hold", "resume", "resume", "skip", "return_home", "abort", "go_to", "cancel", "release", "timeout")
    )
    at_s = rng.choice((rng.uniform(0.0, 12.0), rng.uniform(0.0, 12.0), rng.uniform(0.0, 300.0)))
    command: Content = {"at_s": at_s, "do": "set_timeout" if do == "timeout" else do}
    if do == "go_to":
        command["position_m"] = [rng.uniform(-3, 3), rng.uniform(-3, 3)]
        command["timeout_s"] = 6.0
    elif do == "cancel":
        command["command"] = rng.randint(1, 3)
    elif do == "release":
        command["released"] = -1
    elif do == "timeout":
        command["timeout_s"] = rng.choice((1.0, 10.0))
    if rng.random() < 0.25:
        command["not_before_s"] = at_s + rng.choice((0.5, 4.0, 60.0))
    if rng.random() < 0.2:
        command["expires_s"] = max(at_s, command.get("not_before_s", 0.0)) + rng.choice((0.5, 5.0, 50.0))
    return command
