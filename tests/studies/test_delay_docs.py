"""docs/delay.md is what docs/delay_study.py makes of what was found."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from tests.studies.test_study_tables import study
from waypointctl.flight.checks.link import JOINT_FALLS_FROM_S

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = runpy.run_path(str(ROOT / "docs" / "delay_study.py"))
MARKERS = ("<!-- python docs/delay_study.py -->", "<!-- end -->")


def test_the_page_is_what_was_found() -> None:
    text = (ROOT / "docs" / "delay.md").read_text(encoding="utf-8")
    (block,) = re.findall(rf"{MARKERS[0]}\n(.*?)\n{MARKERS[1]}", text, re.DOTALL)
    assert block == SCRIPT["block"]()
    assert (ROOT / "docs" / "delay.png").read_bytes().startswith(b"\x89PNG")


def test_the_page_shows_from_which_round_trip_on_validate_warns_of_joint() -> None:
    table = (ROOT / "docs" / "delay.md").read_text().partition("**joint, by round trip**")[2]
    rows = [line.split("|") for line in table.splitlines() if re.match(r"\| 0", line)]
    successes = {float(cells[1]): (cells[2].strip(), cells[6].strip()) for cells in rows}
    assert len(successes) > 5
    for round_trip_s, reached in successes.items():
        assert (reached == ("0/20", "0/20")) == (round_trip_s >= JOINT_FALLS_FROM_S)


def test_the_block_and_nothing_else_is_written(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "delay-study.json").write_text(study().model_dump_json())
    page = tmp_path / "docs" / "delay.md"
    page.write_text(f"before\n{MARKERS[0]}\nold\n{MARKERS[1]}\nafter\n")
    SCRIPT["write_page"](tmp_path)
    text = page.read_text()
    assert text.startswith(f"before\n{MARKERS[0]}\n![")
    assert text.endswith(f"|\n{MARKERS[1]}\nafter\n")
    assert "**r: 2 waypoints, 21.2 m**" in text


def test_a_page_without_the_block_is_refused(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "delay-study.json").write_text(study().model_dump_json())
    (tmp_path / "docs" / "delay.md").write_text("nothing\n")
    with pytest.raises(SystemExit, match="0 blocks"):
        SCRIPT["write_page"](tmp_path)
