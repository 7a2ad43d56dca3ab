"""Names that would steer a terminal, wherever they are given or stand in a file: no command prints them raw."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from tests.cli.flying import EASY, Program
from tests.replay.rewriting import Flown, fly_once
from waypointctl.log.messages import Ack, Command, Event
from waypointctl.policy.bundle import LoadedPolicy

HOSTILE = "\x1b]0;owned\x07\x1b[2J\nerror: forged\r\x9b31m\u202egnp\u200b\udcff"
RAW = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ud800-\udfff]")

ONE_FLIGHT = ("--seeds", "1", "--rtt", "0", "--route", "short", "--autonomy", "mission", "--jobs", "1")


def refuse_raw(*texts: str) -> None:
    for text in texts:
        assert RAW.findall(text) == []
        assert "\nerror: forged" not in text
        assert "Traceback" not in text


@pytest.fixture
def field(yard: Path, make_policy: Callable[..., LoadedPolicy]) -> Path:
    """A folder in which all that can be named is named so."""
    make_policy(yard / "policies" / HOSTILE, gain=0.0)
    make_policy(yard / "policies" / "damaged")
    manifest = yard / "policies" / "damaged" / "manifest.json"
    found = json.loads(manifest.read_text())
    manifest.write_text(json.dumps(found | {HOSTILE: 1, "robot": HOSTILE, "network": {"activation": HOSTILE}}))
    for suffix in (".yaml", ".plan", ".geojson", ".mcap", ".zip", ".xyz"):
        (yard / f"{HOSTILE}{suffix}").write_text(f"{HOSTILE!r}: [")
    (yard / f"good{HOSTILE}.yaml").write_text(EASY)
    (yard / f"elsewhere{HOSTILE}.yaml").write_text(EASY.replace("still", json.dumps(f"nowhere{HOSTILE[:-1]}")))
    (yard / "content.yaml").write_text(
        f"name: {json.dumps(HOSTILE[:-1])}\npolicy: still\n{json.dumps(HOSTILE[:-1])}: 1\n"
        f"link: {{jitter_file: {json.dumps(HOSTILE[:-1])}}}\nwaypoints: [[1, 1]]\n"
    )
    (yard / "content.geojson").write_text(
        json.dumps(
            {
                "type": "Feature",
                "properties": {"name": HOSTILE},
                "geometry": {"type": "LineString", "coordinates": [[25, 60], [25.0001, 60]]},
            }
        )
    )
    (yard / "content.json").write_text(json.dumps({"type": HOSTILE}))
    return yard


@pytest.mark.parametrize(
    "arguments",
    [
        ("run", f"{HOSTILE}.yaml"),
        ("run", f"good{HOSTILE}.yaml"),
        ("run", f"good{HOSTILE}.yaml", "--out", f"{HOSTILE}.log"),
        ("run", f"good{HOSTILE}.yaml", f"{HOSTILE}.yaml", "--junit", f"{HOSTILE}.xml"),
        ("run", f"elsewhere{HOSTILE}.yaml"),
        ("run", "easy.yaml", "--policy", HOSTILE),
        ("run", "easy.yaml", "--policy", "policies/damaged"),
        ("run", "--resume", f"{HOSTILE}.mcap"),
        ("run", "--resume", f"absent{HOSTILE}", "--json"),
        ("replay", f"{HOSTILE}.mcap"),
        ("info", f"{HOSTILE}.mcap"),
        ("validate", f"{HOSTILE}.yaml", f"good{HOSTILE}.yaml", "content.yaml", f"elsewhere{HOSTILE}.yaml"),
        ("validate", "content.yaml", "--json"),
        ("validate", "easy.yaml", "--policy", HOSTILE),
        ("fmt", f"{HOSTILE}.yaml", f"good{HOSTILE}.yaml", "content.yaml"),
        ("fmt", "--diff", f"good{HOSTILE}.yaml", "content.yaml"),
        ("import", f"{HOSTILE}.plan"),
        ("import", f"{HOSTILE}.geojson"),
        ("import", "content.geojson", "--policy", HOSTILE),
        ("import", "content.geojson", "--out", f"{HOSTILE}.new"),
        ("import", "content.geojson", "--origin", HOSTILE),
        ("schema", HOSTILE),
        ("init", HOSTILE),
        ("--limit", HOSTILE, "schema"),
        ("policies",),
        ("policies", "--json"),
        ("policies", "show", f"policies/{HOSTILE}"),
        ("policies", "show", "policies/damaged"),
        ("policies", "import", f"{HOSTILE}.zip", "--out", "new", "--observation", "egocentric"),
        ("policies", "import", f"absent{HOSTILE}", "--out", HOSTILE, "--observation", HOSTILE),
        ("eval", f"policies/{HOSTILE}", "--suite", HOSTILE),
        ("eval", "policies/damaged"),
        ("train", f"{HOSTILE}.yaml"),
        ("study", "delay", "--policy", HOSTILE, *ONE_FLIGHT),
        ("study", "delay", "--policy", "still", "--rtt", HOSTILE),
        (HOSTILE,),
        ("run", f"--{HOSTILE}"),
    ],
    ids=lambda arguments: " ".join(arguments).replace(HOSTILE, "X"),
)
def test_no_command_prints_them_raw(field: Path, program: Program, arguments: tuple[str, ...]) -> None:
    code, out, err = program(*arguments)
    assert code in (0, 1, 2)
    assert out + err
    refuse_raw(out, err)
    for report in field.glob("*.xml"):
        refuse_raw(report.read_text())
        assert len(ElementTree.parse(report).findall(".//testcase")) == 2


def hostile(message: Any) -> Any:
    match message:
        case Event():
            return replace(message, text=f"{message.text}{HOSTILE[:-1]}")
        case Ack():
            return replace(message, reason=HOSTILE[:-1])
        case Command():
            return replace(message, waypoints=tuple(replace(each, name=HOSTILE[:-1]) for each in message.waypoints))
    return message


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Flown:
    folder = tmp_path_factory.mktemp("flight")
    return fly_once(folder, make_policy(folder / "policy", seed=7))


@pytest.mark.parametrize(
    "arguments",
    [
        ("replay",),
        ("replay", "--json"),
        ("replay", "--verify"),
        ("replay", "--rate", "1000"),
        ("info",),
        ("run", "--resume"),
    ],
    ids=" ".join,
)
def test_no_command_prints_what_stands_in_a_log_raw(
    flown: Flown, yard: Path, program: Program, arguments: tuple[str, ...]
) -> None:
    messages = [hostile(message) for message in flown.messages]
    metadata = {HOSTILE[:-1]: HOSTILE[:-1], "version_numpy": HOSTILE[:-1], "source": HOSTILE[:-1]}
    log = flown.rewritten(yard / "hostile.mcap", messages, metadata=metadata)
    code, out, err = program(*arguments, str(log))
    assert code in (0, 1, 2)
    refuse_raw(out, err)
