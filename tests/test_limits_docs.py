"""docs/limits.md has every limit that can be changed, with its default."""

from __future__ import annotations

import re
from pathlib import Path

from waypointctl.limits import LIMITS

PAGE = (Path(__file__).resolve().parent.parent / "docs" / "limits.md").read_text(encoding="utf-8")


def test_the_table_is_what_there_is() -> None:
    rows = re.findall(r"^\| `([\w-]+)` \| ([^|]+) \|", PAGE, re.MULTILINE)
    assert rows == [(name, each.text(each.default)) for name, each in LIMITS.items()]
