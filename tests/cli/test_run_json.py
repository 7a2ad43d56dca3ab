"""`run --json` says of a flight what `replay --json` says of its log."""

from __future__ import annotations

import json
import os
import signal
import time
from pathlib import Path
from typing import Any

import pytest

from tests.cli.flying import Program, start
from waypointctl.cli.flight_view import json_text
from waypointctl.replay.flight_log import FlightLog
from waypointctl.replay.summary import summary_json

ROOT = Path(__file__).parents[2]
WALKING = "name: walking\npolicy: still\nwaypoints: [{name: away, position: [50 m, 50 m], timeout: 1 h}]\n"


def told(path: Path) -> Any:
    """Return a log's summary, as `replay --json` has it."""
    log = FlightLog.open(path)
    return json.loads(json_text(summary_json(log.summary, log.mission_name)))


@pytest.mark.slow
def test_of_several_shipped_missions(yard: Path, program: Program) -> None:
    missions = [str(ROOT / "missions" / f"{name}.yaml") for name in ("crater-detour", "lossy-link")]
    code, out, _ = program("run", *missions, "--json")
    flights = json.loads(out)["missions"]
    assert (code, [flight["file"] for flight in flights]) == (0, missions)
    for flight in flights:
        assert flight["summary"] == told(yard / flight["log"])
        assert flight["summary"]["distance_m"] > 1


def test_of_one_flight_that_succeeds_or_fails(yard: Path, program: Program) -> None:
    for mission, outcome in (("easy", "success"), ("far", "failure")):
        found = json.loads(program("run", f"{mission}.yaml", "--json")[1])
        replayed = json.loads(program("replay", found["log"], "--json")[1])
        assert found["outcome"] == found["summary"]["outcome"] == outcome
        assert found["summary"] == replayed["summary"]
    again = json.loads(program("run", "--resume", "logs/easy.mcap", "--json")[1])  # it is complete
    assert again["summary"] == told(yard / "logs" / "easy.mcap")


def test_of_an_interrupted_flight_and_of_one_that_was_not_flown(yard: Path) -> None:
    (yard / "walking.yaml").write_text(WALKING)
    with (yard / "out.json").open("wb") as out:
        flying = start(yard, "run", "walking.yaml", "easy.yaml", "missing.yaml", "--json", stdout=out.fileno())
        part = yard / "logs" / "walking.mcap.part"
        until = time.monotonic() + 60
        while (not part.exists() or part.stat().st_size == 0) and time.monotonic() < until:
            time.sleep(0.02)
        os.kill(flying.pid, signal.SIGINT)
        assert flying.wait(60) == 130
    walking, *others = json.loads((yard / "out.json").read_bytes())["missions"]
    assert walking["summary"]["outcome"] == "interrupted"
    assert walking["summary"] == told(yard / walking["log"])
    assert [other["outcome"] for other in others] == ["skipped", "skipped"]
    assert not any("summary" in other for other in others)
