"""Missions to fly in a test, scripted policies to fly them, and what to ask of the messages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.fly import fly
from waypointctl.flight.outcome import FlightResult
from waypointctl.log.messages import Event, EventKind, Message
from waypointctl.mission.mission import Mission
from waypointctl.policy.protocol import Policy

FloatArray = NDArray[np.float64]
T = TypeVar("T")

TICK_NS = 20_000_000
MS = 1_000_000

# Torques that throw the ant on its back within a few seconds.
TUMBLE = np.array([-1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0, -1.0])
STILL = np.zeros(8)

UNDER_FOOT = {"position_m": [0.0, 0.0], "tolerance_m": 50.0}  # reached as soon as it is asked for
OUT_OF_REACH = {"position_m": [500.0, 0.0], "timeout_s": 1.0}


class Scripted(Policy):
    """A policy that does the same whatever it sees."""

    robot = "ant"
    observation_layout = "egocentric"
    reward_weights: Mapping[str, float] = {"progress": 1.0, "fall": 200.0}

    def __init__(self, action: FloatArray) -> None:
        self._action = action

    def act(self, observation: FloatArray) -> FloatArray:
        return np.tile(self._action, (len(observation), 1))


def mission_of(*waypoints: Mapping[str, Any], delay_ms: float = 0.0, **changes: Any) -> Mission:
    """Return a mission through `waypoints`, each as a mission file's mapping, over a link with the same delay twice."""
    way = {"delay_s": delay_ms / 1000}
    content = {"name": "test", "policy": "none", "waypoints": list(waypoints), "link": {"up": way, "down": way}}
    return Mission.model_validate(content | changes)


def flown(mission: Mission, policy: Policy | None = None) -> tuple[FlightResult, list[Message]]:
    """Fly a mission; return how it ended and every message."""
    messages: list[Message] = []
    result = fly(mission, policy or Scripted(STILL), messages.append)
    return result, messages


def only(kind: type[T], messages: list[Message]) -> list[T]:
    """Return the messages of one kind."""
    return [message for message in messages if isinstance(message, kind)]


def times_ns(kind: EventKind, messages: list[Message]) -> list[int]:
    """Return when events of a kind happened."""
    return [event.time_ns for event in only(Event, messages) if event.kind is kind]


def next_tick(time_ns: int) -> int:
    """Return the first control step that begins at or after a time [ns]."""
    return -(-time_ns // TICK_NS) * TICK_NS
