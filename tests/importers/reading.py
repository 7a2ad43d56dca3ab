"""Files of other tools, imported as `waypointctl import` does it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from waypointctl.importers.conversion import mission_text, read_imported
from waypointctl.importers.importer import ImportedMission
from waypointctl.importers.local_frame import Body, Place
from waypointctl.importers.placed import Placed
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Leg, Mission


@dataclass(frozen=True)
class Imported:
    """What became of a file."""

    mission: Mission
    text: str
    source: ImportedMission
    placed: Placed

    @property
    def legs(self) -> list[tuple[float, float]]:
        """The waypoints' places [m], to the centimetre."""
        return [(round(leg.x_m, 2) + 0.0, round(leg.y_m, 2) + 0.0) for leg in self.all_legs]

    @property
    def all_legs(self) -> tuple[Leg, ...]:
        return self.mission.legs()

    @property
    def left_out(self) -> tuple[str, ...]:
        return self.placed.left_out


def write(path: Path, content: object) -> Path:
    """Write a file: bytes and text as they are, anything else as JSON."""
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


def imported(
    folder: Path, content: object, name: str = "yard.plan", origin: Place | None = None, body: Body | None = None
) -> Imported:
    """Import what a file holds."""
    source = read_imported(write(folder / name, content))
    text, placed = mission_text(source, name, "p", origin, body)
    return Imported(parse_mission(text.encode(), "mission"), text, source, placed)
