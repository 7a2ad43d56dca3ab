"""docs/limits.md has every limit that can be changed, with its default, and every operator that a network may have."""

from __future__ import annotations

import re
from pathlib import Path

from waypointctl.limits import LIMITS
from waypointctl.policy.onnx_shapes import RULES

PAGE = (Path(__file__).resolve().parent.parent / "docs" / "limits.md").read_text(encoding="utf-8")


def test_the_table_is_what_there_is() -> None:
    rows = re.findall(r"^\| `([\w-]+)` \| ([^|]+) \|", PAGE, re.MULTILINE)
    assert rows == [(name, each.text(each.default)) for name, each in LIMITS.items()]


def test_the_operators_are_those_that_are_read() -> None:
    section = PAGE.partition("The operators are deterministic")[2].partition("Refused are")[0]
    rows = re.findall(r"^\| [a-z]+ \| (.*) \|$", section, re.MULTILINE)
    listed = [name for row in rows for name in re.findall(r"\b[A-Z]\w+", row)]
    assert sorted(listed) == sorted(RULES)


def test_the_log_of_any_policy_that_is_read_is_read() -> None:
    largest = LIMITS["policy-file"].default
    assert LIMITS["log-record"].default > largest + 2**20
    assert LIMITS["log-attachments"].default > 2 * largest + 2**22
