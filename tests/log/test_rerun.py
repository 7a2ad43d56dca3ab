"""Rerun's own reader, in another language and by other hands, takes a log as it is.

It is no dependency: the tests run where `rerun` is installed (`pip install rerun-sdk`).
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.log.fake_flight import FakeKinematics, flight
from waypointctl.log.messages import State
from waypointctl.log.reader import open_log

NEXT_TO_PYTHON = Path(sys.executable).parent
RERUN = shutil.which("rerun", path=f"{NEXT_TO_PYTHON}{os.pathsep}{os.environ.get('PATH', '')}")

pytestmark = pytest.mark.skipif(
    RERUN is None, reason="there is no `rerun` on the path or next to Python; it comes with rerun-sdk"
)


def rerun(home: Path, *words: str) -> str:
    """Run rerun, which shall find a home of its own: it keeps its settings there. Return what it says."""
    assert RERUN is not None
    environment = os.environ | {"HOME": str(home), "XDG_CONFIG_HOME": str(home), "NO_COLOR": "1"}
    done = subprocess.run([RERUN, *words], check=False, capture_output=True, text=True, env=environment, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_rerun_sees_every_channel_and_message(log_path: Path, tmp_path: Path) -> None:
    log = open_log(log_path)
    lines = [line.split() for line in rerun(tmp_path, "mcap", "info", str(log_path)).splitlines()]
    channels = {words[1]: words[2] for words in lines if len(words) > 3 and words[1].startswith("/")}
    assert channels == {name: str(topic.count) for name, topic in log.topics.items()}
    assert ["Messages", str(log.message_count)] in lines


def test_rerun_finds_nothing_wrong(log_path: Path, tmp_path: Path) -> None:
    lines = [line.split() for line in rerun(tmp_path, "mcap", "check", str(log_path)).splitlines()]
    verdicts = {words[3]: words[0] for words in lines if len(words) > 4 and words[3].startswith("/")}
    assert verdicts == dict.fromkeys(open_log(log_path).topics, "ok")


def test_rerun_imports_every_topic(log_path: Path, tmp_path: Path) -> None:
    out = tmp_path / "flight.rrd"
    said = rerun(tmp_path, "mcap", "convert", str(log_path), "-o", str(out))
    assert out.stat().st_size > 0
    assert not [line for line in said.splitlines() if "ERROR" in line]
    entities = {line.strip(" ,") for line in said.splitlines()}
    assert set(open_log(log_path).topics) <= entities


def test_rerun_knows_the_poses_and_when_they_were(log_path: Path, tmp_path: Path) -> None:
    out = tmp_path / "flight.rrd"
    rerun(tmp_path, "mcap", "convert", str(log_path), "-o", str(out), "-y", "^/tf$")
    rows = printed_rows(rerun(tmp_path, "rrd", "print", "-vvv", "--entity", "/tf", str(out)), "Transform3D:translation")
    torso = {time_ns(row["timestamp"]): row for row in rows if row["Transform3D:child_frame"] == "[torso]"}
    moves = [state for state in flight() if isinstance(state, State) and state.step % 2 == 0]
    assert len(rows) == len(FakeKinematics.body_names) * len(moves)
    for state in moves:
        row = torso[state.time_ns]
        assert row["timestamp"] == row["message_log_time"]
        [position] = json.loads(row["Transform3D:translation"])
        assert position == pytest.approx(state.qpos[:3], abs=1e-6)


def time_ns(printed: str) -> int:
    return int(np.datetime64(printed, "ns").astype(np.int64))


def printed_rows(text: str, column: str) -> list[dict[str, str]]:
    """Return the rows, cell by column, of every table that has this column."""
    rows, names = [], [""]
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("│ ").split("┆")]
        if cells[0] == "RowId":
            names = cells
        elif cells[0].startswith("row_") and column in names:
            rows.append(dict(zip(names, cells, strict=True)))
    return rows
