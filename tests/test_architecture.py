"""Who may import whom, and what a command may load."""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from importlinter import cli as importlinter

from tests.replay.rewriting import MISSION, Flown, fly_once
from waypointctl.policy.bundle import LoadedPolicy

REPOSITORY = Path(__file__).parents[1]
PYPROJECT = REPOSITORY / "pyproject.toml"
PACKAGE = REPOSITORY / "waypointctl"

TRAINING = {"torch", "stable_baselines3", "gymnasium", "tensorboard", "onnx", "safetensors"}

# Runs the command line in this very process and says which packages it has loaded.
PROGRAM = """
import sys
from waypointctl.cli.main import main
code = 0
try:
    main()
except SystemExit as stopped:
    code = stopped.code
print("LOADED", code or 0, *sorted({name.partition(".")[0] for name in sys.modules}))
"""


def test_the_import_contracts_hold(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(REPOSITORY)
    assert importlinter.lint_imports(str(PYPROJECT), no_cache=True) == importlinter.EXIT_STATUS_SUCCESS


def test_every_part_of_the_house_has_its_layer() -> None:
    contracts = tomllib.loads(PYPROJECT.read_text())["tool"]["importlinter"]["contracts"]
    (layers,) = (contract["layers"] for contract in contracts if contract["type"] == "layers")
    named = {name.strip() for layer in layers for name in layer.split("|")}
    found = {f"waypointctl.{path.stem}" for path in PACKAGE.iterdir() if path.is_dir() or path.suffix == ".py"}
    assert (
        found - {"waypointctl.__init__", "waypointctl.__main__", "waypointctl.__pycache__", "waypointctl.py"} == named
    )


def loaded_by(folder: Path, *arguments: str) -> tuple[int, set[str], str]:
    """Return the exit code of a command, the packages that it loaded and what it printed."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, *arguments], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    printed, _, said = done.stdout.rpartition("LOADED ")
    code, *packages = said.split()
    return int(code), set(packages), printed


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Flown:
    folder: Path = tmp_path_factory.mktemp("flight")
    (folder / "mission.yaml").write_bytes(MISSION)
    return fly_once(folder, make_policy(folder / "policy", seed=7))


HEAVY = {*TRAINING, "mujoco", "mjbatch", "numpy", "mcap", "google", "onnxruntime", "matplotlib"}


@pytest.mark.parametrize("arguments", [("--help",), ("--version",), ("run", "--help"), ("replay", "--help")])
def test_help_loads_nothing_heavy(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    code, loaded, printed = loaded_by(tmp_path, *arguments)
    assert code == 0
    assert printed
    assert not loaded & HEAVY


def test_run_flies_without_torch_and_without_pictures(flown: Flown) -> None:
    code, loaded, printed = loaded_by(flown.path.parent, "run", "mission.yaml", "--out", "another.mcap", "--json")
    assert code == 0
    assert '"outcome": "success"' in printed
    assert {"mujoco", "onnxruntime", "mcap"} <= loaded, "it has really flown"
    assert not loaded & (TRAINING | {"matplotlib"})


def test_replay_proves_without_torch_and_without_pictures(flown: Flown) -> None:
    code, loaded, _ = loaded_by(flown.path.parent, "replay", "flight.mcap")
    assert code == 0
    assert {"mujoco", "onnxruntime", "mcap"} <= loaded, "it has really been replayed"
    assert not loaded & (TRAINING | {"matplotlib"})


def test_validate_reads_a_mission_without_a_simulator(flown: Flown) -> None:
    code, loaded, _ = loaded_by(flown.path.parent, "validate", "mission.yaml")
    assert code == 0
    assert not loaded & (HEAVY - {"numpy", "google"} | {"rich"})  # its link has rates: sizes are those of the encoding


def test_validate_loads_no_protobuf_where_no_rate_needs_sizes(tmp_path: Path) -> None:
    code, loaded, _ = loaded_by(tmp_path, "validate", str(REPOSITORY / "missions" / "sample-stops.yaml"))
    assert code == 0
    assert not loaded & (HEAVY - {"numpy"} | {"rich"})


def test_info_reads_a_log_without_a_simulator_and_without_a_policy(flown: Flown) -> None:
    code, loaded, printed = loaded_by(flown.path.parent, "info", "flight.mcap", "--json")
    assert code == 0
    assert json.loads(printed)["messages"]
    assert not loaded & (HEAVY - {"numpy", "google", "mcap"} | {"ruamel", "rich"})
