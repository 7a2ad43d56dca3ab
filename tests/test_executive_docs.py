"""The executive's pages say what its table and its code say."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

from waypointctl.flight.executive.state_machine import TRANSITIONS
from waypointctl.log.messages import CommandKind, Mode
from waypointctl.mission.files import parse_mission

DOCS = Path(__file__).resolve().parent.parent / "docs"
COMMANDS = (DOCS / "commands.md").read_text(encoding="utf-8")


def test_the_machines_page_is_what_its_command_writes() -> None:
    page = runpy.run_path(str(DOCS / "executive.py"))["page"]()
    assert (DOCS / "executive.md").read_text(encoding="utf-8") == page


def test_the_diagram_has_every_transition_and_no_other() -> None:
    text = (DOCS / "executive.md").read_text(encoding="utf-8")
    drawn = set()
    for origin, after, signals in re.findall(r"^    (\w+) --> (\w+): (.+)$", text, re.MULTILINE):
        origins = [mode for mode in Mode if mode is not Mode.FALLEN] if origin == "upright" else [Mode(origin)]
        drawn |= {(mode, signal, Mode(after)) for mode in origins for signal in signals.split(", ")}
    assert drawn == {(mode, signal.value, after) for (mode, signal), after in TRANSITIONS.items()}


def test_every_kind_of_command_has_its_row() -> None:
    assert sorted(re.findall(r"^\| `(\w+)` \| ", COMMANDS, re.MULTILINE)) == sorted(CommandKind)


def test_the_rules_on_the_page_are_read() -> None:
    (block,) = re.findall(r"\n((?:    [^\n]*\n)+)", COMMANDS)
    mission = "name: n\npolicy: p\nwaypoints: [[1, 2]]\n" + re.sub(r"^    ", "", block, flags=re.MULTILINE)
    read = parse_mission(mission.encode(), "docs/commands.md")
    assert read.failure_rule.then == "skip"
    assert read.onboard.home.timeout_s == 300.0
    assert read.onboard.geofence.keep_out[0].name == "crater"
