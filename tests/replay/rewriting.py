"""A short flight that has everything in it, and ways to write its log again with something changed."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from waypointctl.flight.fly import fly
from waypointctl.flight.header import flight_header
from waypointctl.log.messages import Message, State
from waypointctl.log.reader import open_log
from waypointctl.log.writer import LogWriter
from waypointctl.mission.files import MissionFile, parse_mission
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.protocol import Policy
from waypointctl.robots.load import load_robot

MISSION = b"""\
name: everything
policy: ./policy
seed: 4
autonomy: waypoint
on_failure: skip
waypoints:
  - {name: here, position: [0.2 m, 0 m], tolerance: 10 m, hold: 100 ms}
  - {name: far, position: [90 m, 0 m], timeout: 600 ms}
  - {name: there, position: [0 m, 0.2 m], tolerance: 10 m}
link:
  up: {delay: 130 ms, jitter: 20 ms}
  down: {delay: 90 ms, jitter: 60 ms}
expect: {reached: 2}
"""


@dataclass(frozen=True)
class Flown:
    """A flight that has been recorded."""

    mission_file: MissionFile
    policy: Policy
    path: Path

    @property
    def messages(self) -> list[Message]:
        return list(open_log(self.path).messages())

    def rewritten(
        self,
        out: Path,
        messages: Iterable[Message] | None = None,
        *,
        metadata: Mapping[str, str] | None = None,
        attachments: Mapping[str, bytes | None] | None = None,
    ) -> Path:
        """Write the log again with other messages, metadata or attachments (None: left out)."""
        header = flight_header(self.mission_file, self.policy, load_robot("ant"))
        contents = {each.name: each.data for each in header.attachments} | dict(attachments or {})
        header = replace(
            header,
            metadata=dict(header.metadata) | dict(metadata or {}),
            attachments=tuple(
                replace(each, data=data) for each in header.attachments if (data := contents[each.name]) is not None
            ),
        )
        with LogWriter(out, header) as sink:
            for message in self.messages if messages is None else messages:
                sink(message)
        return out


def fly_once(
    folder: Path, policy: LoadedPolicy, source: bytes = MISSION, interrupted: Callable[[], bool] = lambda: False
) -> Flown:
    """Record a flight in `folder`."""
    mission_file = MissionFile(parse_mission(source, "mission.yaml"), source, folder / "mission.yaml")
    fly(mission_file, policy, log=folder / "flight.mcap", interrupted=interrupted)
    return Flown(mission_file, policy, folder / "flight.mcap")


def bit_flipped(value: float, bit: int = 0) -> float:
    """Return the float with one of its 64 bits the other way round."""
    (bits,) = struct.unpack("<Q", struct.pack("<d", value))
    return float(struct.unpack("<d", struct.pack("<Q", bits ^ (1 << bit)))[0])


def altered(message: Any, field: str, index: int | None = None, bit: int = 0) -> Any:
    """Return a record with a field's value changed as little as can be: one bit of a float, one of a number."""
    value = getattr(message, field)
    changed: Any
    if isinstance(value, np.ndarray):
        changed = value.copy()
        changed[index] = bit_flipped(float(value[index]), bit)
    elif isinstance(value, float):
        changed = bit_flipped(value, bit)
    elif isinstance(value, tuple):
        changed = (*value, value[-1]) if value else (0,)
    else:
        changed = value + 1 if isinstance(value, int) else f"{value}."
    return replace(message, **{field: changed})


def step_under_way(messages: list[Message], index: int) -> int:
    """Return the control step in which message `index` of a log was made, counted by the states before it."""
    return max((m.step for m in messages[: index + 1] if isinstance(m, State)), default=0)
