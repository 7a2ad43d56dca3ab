"""`--plugin FILE`: a policy that observes a user's group, through every command that flies it."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from waypointctl.cli.app import app
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import ObservationSpec
from waypointctl.robots.load import load_robot
from waypointctl.task.observation import LAYOUTS, layout
from waypointctl.task.plugins import load_plugins

PLUGIN = """
import waypointctl
@waypointctl.observation_group(name="half_height", unit="m", components=["half_height"])
def half_height(view):
    return view.height / 2
"""
SHA256 = hashlib.sha256(PLUGIN.encode()).hexdigest()
MISSION = "name: short\npolicy: ./own\nwaypoints: [{position: [9 m, 0 m], timeout: 0.2 s}]\n"


@pytest.fixture
def folder(tmp_path: Path, make_policy: Callable[..., LoadedPolicy], monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working directory, with a mission, the policy and the plugin that it was trained with."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "terms.py").write_text(PLUGIN)
    groups = tuple("half_height" if name == "height" else name for name in LAYOUTS["egocentric"])
    seen = layout(groups, load_robot("ant"), load_plugins("terms.py"))
    names, units, scales = zip(*seen.components, strict=True)
    observation = ObservationSpec(
        layout=seen.name, groups=seen.groups, size=seen.size, names=names, units=units, scales=scales
    )
    make_policy(tmp_path / "own", observation=observation, plugins={"terms.py": SHA256})
    (tmp_path / "m.yaml").write_text(MISSION)
    return tmp_path


def invoked(*arguments: str, code: int, plugin: str | None = "terms.py") -> Result:
    given = [] if plugin is None else ["--plugin", plugin]
    result = CliRunner().invoke(app, [*arguments, *given], standalone_mode=True)
    assert result.exit_code == code, (result.output, result.exception)
    return result


def refusal(*arguments: str, plugin: str | None = None) -> str:
    result = CliRunner().invoke(app, [*arguments, *([] if plugin is None else ["--plugin", plugin])])
    return f"{result.exception}{result.output}"


@pytest.mark.parametrize(
    "arguments", [["run", "m.yaml"], ["run", "m.yaml", "--dry-run"], ["eval", "own", "--trials", "1"]]
)
def test_without_the_plugin_it_is_refused_with_its_name_and_hash(folder: Path, arguments: list[str]) -> None:
    alone = refusal(*arguments)
    assert f"the policy observes 'half_height' of the plugin terms.py (SHA-256 {SHA256})\n" in alone
    assert "Give it with --plugin" in alone
    assert "available" not in alone
    (folder / "other.py").write_text(f"{PLUGIN}# another\n")
    text = refusal(*arguments, plugin="other.py")
    assert f"terms.py (SHA-256 {SHA256})" in text
    assert hashlib.sha256((folder / "other.py").read_bytes()).hexdigest() in text


def test_a_flight_and_its_log(folder: Path) -> None:
    invoked("run", "m.yaml", "--out", "a.mcap", code=1)  # it does not come far in 0.2 s
    found = json.loads(invoked("replay", "a.mcap", "--json", code=0).stdout)
    assert found["verdict"] == "exact"
    without = json.loads(invoked("replay", "a.mcap", "--json", code=1, plugin=None).stdout)
    assert (without["verdict"], SHA256 in without["reason"]) == ("unverifiable", True)
    (folder / "a.mcap").rename(folder / "b.mcap.part")
    (folder / "b.mcap.part").write_bytes((folder / "b.mcap.part").read_bytes()[:-2000])
    assert SHA256 in refusal("run", "--resume", "b.mcap")
    invoked("run", "--resume", "b.mcap", code=1)
    assert json.loads(invoked("replay", "b.mcap", "--json", code=0).stdout)["verdict"] == "exact"


def test_several_flights_rehearsals_and_evaluations(folder: Path) -> None:
    invoked("run", "m.yaml", "m.yaml", code=1)
    invoked("run", "m.yaml", "--dry-run", code=1)
    invoked("eval", "own", "--suite", "region", "--trials", "1", code=0)
    assert "OK m.yaml" in invoked("validate", "m.yaml", code=0).stdout
    assert SHA256 in invoked("validate", "m.yaml", code=2, plugin=None).stdout
    assert "0 of 5 flights" in invoked("validate", "m.yaml", "--rehearse", "5", "--jobs", "2", code=1).stdout


def test_a_study(folder: Path) -> None:
    arguments = ["study", "delay", "--policy", "own", "--quick", "--rtt", "0", "--autonomy", "mission", "--seeds", "1"]
    assert SHA256 in refusal(*arguments)
    invoked(*arguments, code=0)


def test_the_manifest_is_read_without_the_simulator_where_nothing_is_executed(folder: Path) -> None:
    code = (
        "import sys\nfrom typer.testing import CliRunner\nfrom waypointctl.cli.app import app\n"
        "CliRunner().invoke(app, ['validate', 'm.yaml'])\n"
        "print([name for name in ('mujoco', 'onnxruntime', 'torch') if name in sys.modules])"
    )
    assert subprocess.check_output([sys.executable, "-c", code], text=True, cwd=folder).strip() == "[]"
