"""Missions as YAML files: in, out, and the JSON Schema for editors."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from waypointctl.errors import MissionError
from waypointctl.mission.checks import SCHEMA_VERSION
from waypointctl.mission.mission import Mission
from waypointctl.mission.policy_name import policy_folder
from waypointctl.mission.references import among, beside, examine_mission
from waypointctl.mission.yaml_source import Reading, as_error, read_source
from waypointctl.mission.yaml_tree import read_tree


@dataclass(frozen=True, slots=True)
class MissionFile:
    """A mission and the file that it came from."""

    mission: Mission
    source: bytes
    path: Path

    @property
    def files(self) -> Mapping[str, bytes]:
        """The contents of the files that the mission refers to, by their names in it."""
        return self.mission.files

    @property
    def policy_path(self) -> Path:
        """The policy bundle's folder, which a mission names relative to its own file, or by a bare name."""
        return policy_folder(self.mission.policy, self.path.parent)

    def place(self, key: str) -> str:
        """Return where the file has a key's value, "file:line:column"; the file alone where it does not have it."""
        mark = read_tree(self.source).values.get((key,))
        return f"{self.path}:{mark.line}:{mark.column}" if mark else str(self.path)


def load_mission(path: Path | str) -> MissionFile:
    """Read a mission file, and the files that it refers to.

    Raises:
        MissionError: there is no such file, it is not a mission, or something is wrong with a file that it refers to.
    """
    path = Path(path)
    source = read_source(path, MissionError)
    return MissionFile(_mission(examine_mission(source, str(path), beside(path))), source, path)


def parse_mission(source: bytes, where: str, files: Mapping[str, bytes] | None = None) -> Mission:
    """Read a mission from YAML text.

    Args:
        source: the text.
        where: names it in messages.
        files: the contents of the files that it refers to, by their names in it.

    Raises:
        MissionError: it is not a mission; everything wrong with it is listed with line and column.
    """
    return _mission(examine_mission(source, where, among(files or {})))


def _mission(reading: Reading[Mission]) -> Mission:
    if reading.model is None:
        raise as_error(reading.problems, MissionError)
    return reading.model


def dump_mission(mission: Mission) -> str:
    """Return a mission as YAML that reads back as an equal mission; what is left to a default is left out."""
    from ruamel.yaml import YAML

    stream = io.StringIO()
    yaml = YAML()
    yaml.width = 2**20  # never fold a text
    content = mission.model_dump(exclude_defaults=True)
    if mission.link.preset is not None:
        content["link"] = mission.link.model_dump()  # a value left out would be the preset's, not the default
    yaml.dump(_for_yaml(content), stream)
    return stream.getvalue()


def mission_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 7) of a mission file, with every spelling that is read."""
    from waypointctl.mission.file_schema import model_schema

    return {"$id": f"urn:waypointctl:mission:{SCHEMA_VERSION}", **model_schema(Mission, "waypointctl mission")}


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
