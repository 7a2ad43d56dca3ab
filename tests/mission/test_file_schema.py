"""The schema, tried with a JSON Schema validator that knows nothing of the models."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import fastjsonschema
import pytest

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.files import mission_schema
from waypointctl.mission.mission import Mission
from waypointctl.mission.yaml_source import examine
from waypointctl.mission.yaml_tree import read_tree

SHIPPED = sorted((Path(__file__).parents[2] / "missions").glob("*.yaml"))
BASE = "name: n\npolicy: p\n"


@pytest.fixture(scope="module")
def accepts() -> Callable[[str], bool]:
    check = fastjsonschema.compile(mission_schema())

    def accepts(text: str) -> bool:
        try:
            check(read_tree(text.encode()).data)
        except fastjsonschema.JsonSchemaException:
            return False
        return True

    return accepts


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_accepts_every_shipped_mission(path: Path, accepts: Callable[[str], bool]) -> None:
    assert accepts(path.read_text())


@pytest.mark.parametrize(
    "text",
    [
        "waypoints: [[7, 12]]",
        "waypoints: [[7 m, 120 cm]]",
        "waypoints: [{position_m: [7, 12]}, {position: [7 m, -12.5 cm], timeout: 2e1 s, tolerance: .5m}]",
        "waypoints: [[7, 12]]\nlink: {delay: 1.28 s, jitter_s: 0.05}",
        "waypoints: [[7, 12]]\nlink: {up: {delay: 1 d}, down: {delay_s: 3}}",
        "waypoints: [[7, 12]]\nlink: {preset: moon, loss: 2 %, rate: 64 kbit/s, queue: 2 KiB, keep_order: false}",
        "waypoints: [[7, 12]]\nlink: {up: {loss: {p: 0.1, r: 1 %}}, down: {loss: 0.1, duplicate: 1e-3}}",
        "waypoints: [[7, 12]]\n"
        "link: {windows: [{from: 0 s, to: 1 min}, {from_s: 70, to_s: 80}], windows_period: 2 min}",
        "waypoints: [[7, 12]]\nlink: {delay_table: [{at: 0 s, delay: 1 s}, {at_s: 5, delay_s: 2}]}",
        "waypoints: [[7, 12]]\nstart: {position: [1 m, 2 m], heading: 1.57 rad}\ntelemetry: {rate: 5 Hz}",
        "waypoints: [[7, 12]]\nexpect: {reached: 0, max_time: 3 min}",
    ],
)
def test_accepts_both_spellings_as_the_reader_does(text: str, accepts: Callable[[str], bool]) -> None:
    assert accepts(BASE + text)
    assert examine((BASE + text).encode(), "m", Mission).problems == ()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "waypoints: []",
        "waypoints: [[7]]",
        "waypoints: [[7 m, 12]]",
        "waypoints: [[7, 12, 0]]",
        "waypoints: [{}]",
        "waypoints: [{position: [7, 12]}]",
        "waypoints: [{position_m: [7 m, 12 m]}]",
        "waypoints: [{position_m: [7, 12], position: [7 m, 12 m]}]",
        "waypoints: [{position_m: [7, 12], timeout: 20}]",
        "waypoints: [{position_m: [7, 12], timeout: 20 m}]",
        "waypoints: [{position_m: [7, 12], timeout: 20 s, timeout_s: 20}]",
        "waypoints: [{position_m: [7, 12], tolerance_m: 0}]",
        "waypoints: [{position_m: [7, 12], tolerence_m: 1}]",
        "waypoints: [[7, 12]]\nlink: {delay: 1 s, up: {delay: 1 s}}",
        "waypoints: [[7, 12]]\nlink: {delay: 1 s, delay_s: 1}",
        "waypoints: [[7, 12]]\nlink: {dealy: 1 s}",
        "waypoints: [[7, 12]]\nlink: {preset: mon}",
        "waypoints: [[7, 12]]\nlink: {loss: 2}",
        "waypoints: [[7, 12]]\nlink: {loss: {p: 0.1}}",
        "waypoints: [[7, 12]]\nlink: {rate: 5}",
        "waypoints: [[7, 12]]\nlink: {rate: 5 kbps}",
        "waypoints: [[7, 12]]\nlink: {windows: []}",
        "waypoints: [[7, 12]]\nlink: {contact_plan: {file: p, from_node: one, to_node: 2}}",
        "waypoints: [[7, 12]]\ntelemetry: {rate_hz: 51}",
        "waypoints: [[7, 12]]\nseed: -1",
        "waypoints: [[7, 12]]\nseed: 1.5",
        "waypoints: [[7, 12]]\nexpect: {reached: some}",
        "waypoints: [[7, 12]]\nwaypoint: []",
    ],
)
def test_marks_what_the_reader_refuses(text: str, accepts: Callable[[str], bool]) -> None:
    assert not accepts(BASE + text)
    assert examine((BASE + text).encode(), "m", Mission).problems


def test_every_key_that_is_read_is_in_the_schema_and_no_other() -> None:
    schema = mission_schema()
    pending: list[tuple[type[FileModel], dict[str, Any]]] = [(Mission, schema)]
    for model, part in pending:
        as_mapping = next((each for each in part.get("anyOf", []) if "properties" in each), part)
        assert set(as_mapping["properties"]) == set(model.known_keys())
        assert as_mapping["additionalProperties"] is False
        for inner in _models_of(model):
            pending.append((inner, schema["$defs"][inner.__name__]))
    assert len(pending) > 6


def _models_of(model: type[FileModel]) -> list[type[FileModel]]:
    parts = [field.annotation for field in model.model_fields.values()]
    parts += [inner for part in parts for inner in getattr(part, "__args__", ())]
    return [part for part in parts if isinstance(part, type) and issubclass(part, FileModel)]


def test_only_words_of_draft_7_are_used() -> None:
    schema = mission_schema()
    assert schema["$schema"] == "http://json-schema.org/draft-07/schema#"
    assert "prefixItems" not in str(schema)
