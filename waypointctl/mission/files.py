"""Missions as YAML files: in, out, and the JSON Schema for editors."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from waypointctl.errors import MissionError
from waypointctl.mission.mission import Mission
from waypointctl.mission.yaml_source import read_model, read_source
from waypointctl.mission.yaml_tree import read_tree


@dataclass(frozen=True, slots=True)
class MissionFile:
    """A mission and the file that it came from."""

    mission: Mission
    source: bytes
    path: Path

    @property
    def policy_path(self) -> Path:
        """The policy bundle's folder, which a mission names relative to its own file."""
        return self.path.parent / self.mission.policy

    @property
    def policy_place(self) -> str:
        """Where the file names its policy: "file:line:column"."""
        mark = read_tree(self.source).values.get(("policy",))
        return f"{self.path}:{mark.line}:{mark.column}" if mark else str(self.path)


def load_mission(path: Path) -> MissionFile:
    """Read a mission file.

    Raises:
        MissionError: there is no such file, or it is not a mission.
    """
    source = read_source(path, MissionError)
    return MissionFile(parse_mission(source, str(path)), source, path)


def parse_mission(source: bytes, where: str) -> Mission:
    """Read a mission from YAML text; `where` names it in messages.

    Raises:
        MissionError: it is not a mission; everything wrong with it is listed with line and column.
    """
    return read_model(source, where, Mission, MissionError)


def dump_mission(mission: Mission) -> str:
    """Return a mission as YAML that reads back as an equal mission; what is left to a default is left out."""
    from ruamel.yaml import YAML

    stream = io.StringIO()
    yaml = YAML()
    yaml.width = 2**20  # never fold a text
    yaml.dump(_for_yaml(mission.model_dump(exclude_defaults=True)), stream)
    return stream.getvalue()


def mission_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 7) of a mission file, with every spelling that is read."""
    from waypointctl.mission.file_schema import model_schema

    return model_schema(Mission, "waypointctl mission")


def _for_yaml(value: Any) -> Any:
    """Return plain data for the YAML writer: text in quotes, since what it leaves bare may read as a number."""
    from ruamel.yaml.comments import CommentedSeq
    from ruamel.yaml.scalarstring import DoubleQuotedScalarString

    if isinstance(value, dict):
        return {key: _for_yaml(part) for key, part in value.items()}
    if isinstance(value, tuple):
        sequence = CommentedSeq(_for_yaml(part) for part in value)
        if all(isinstance(part, float) for part in value):
            sequence.fa.set_flow_style()
        return sequence
    return DoubleQuotedScalarString(value) if isinstance(value, str) else value
