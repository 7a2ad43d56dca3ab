"""The page of a mission's keys says what the models say."""

from __future__ import annotations

import re
import runpy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from waypointctl.mission.files import mission_schema
from waypointctl.units import bare_name

DOCS = Path(__file__).resolve().parent.parent / "docs"
PAGE = (DOCS / "mission.md").read_text(encoding="utf-8")


def objects(schema: Any) -> Iterator[set[str]]:
    """Yield the keys of each mapping in a JSON Schema."""
    if isinstance(schema, list):
        for part in schema:
            yield from objects(part)
    elif isinstance(schema, dict):
        if isinstance(schema.get("properties"), dict):
            yield set(schema["properties"])
        for part in schema.values():
            yield from objects(part)


def test_it_is_what_its_command_writes() -> None:
    assert runpy.run_path(str(DOCS / "mission_keys.py"))["page"]() == PAGE


def test_every_key_of_the_schema_is_on_it() -> None:
    tables = [set(re.findall(r"^\| `(\w+)` \|", part, re.MULTILINE)) for part in PAGE.split("\n## ")]
    for keys in objects(mission_schema()):
        bare = {bare_name(key) if bare_name(key) in keys else key for key in keys}
        assert any(bare <= table or bare - {"up", "down", "preset"} <= table for table in tables), bare


def test_its_links_lead_somewhere() -> None:
    titles = re.findall(r"^## (.+)$", PAGE, re.MULTILINE)
    anchors = {re.sub(r"[^\w-]", "", title.lower().replace(" ", "-")) for title in titles}
    linked = set(re.findall(r"\]\(#([^)]+)\)", PAGE))
    assert len(linked) > 12
    assert linked <= anchors
