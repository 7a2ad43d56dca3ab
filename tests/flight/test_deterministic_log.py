"""The same mission, policy and seed give the same bytes, in whatever process."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path

import pytest

from tests.replay.rewriting import MISSION
from waypointctl.policy.bundle import LoadedPolicy

PROGRAM = """
import sys
from dataclasses import replace
from pathlib import Path
from waypointctl.mission.files import load_mission
from waypointctl.flight.fly import fly
from waypointctl.policy.bundle import load_policy
mission, out, seed = load_mission(Path(sys.argv[1])), Path(sys.argv[2]), int(sys.argv[3])
mission = replace(mission, mission=mission.mission.model_copy(update={"seed": seed}))
print(fly(mission, log=out).log_sha256)
"""


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Path:
    folder: Path = tmp_path_factory.mktemp("mission")
    make_policy(folder / "policy", seed=7)
    (folder / "mission.yaml").write_bytes(MISSION)
    return folder / "mission.yaml"


def log_of(mission: Path, out: Path, seed: int, hash_seed: int) -> bytes:
    """Fly in a fresh process; return the log, whose SHA-256 is what the process said it is."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, mission, out, str(seed)],
        env={"PYTHONHASHSEED": str(hash_seed), "PATH": "/usr/bin:/bin"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    content = out.read_bytes()
    assert done.stdout.strip() == sha256(content).hexdigest()
    return content


def test_two_processes_write_the_same_bytes_and_another_seed_others(mission: Path, tmp_path: Path) -> None:
    first = log_of(mission, tmp_path / "first.mcap", 4, hash_seed=1)
    assert log_of(mission, tmp_path / "second.mcap", 4, hash_seed=2) == first
    assert log_of(mission, tmp_path / "third.mcap", 5, hash_seed=1) != first
