"""A flight with observation groups and reward terms of the user's, verified, resumed and refused without them."""

from __future__ import annotations

import hashlib
from contextlib import AbstractContextManager
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.test_api import PLUGIN
from waypointctl.errors import LogError
from waypointctl.flight.fly import fly
from waypointctl.log.reader import open_log
from waypointctl.mission.mission import Mission
from waypointctl.policy.protocol import Policy
from waypointctl.replay.resume import Unfinished, unfinished
from waypointctl.replay.verify import Verdict, verify
from waypointctl.task.plugins import load_plugins, observation_group

SHA256 = hashlib.sha256(PLUGIN.encode()).hexdigest()
MISSION = Mission.model_validate(
    {"name": "still", "policy": "none", "waypoints": [{"position_m": [9.0, 0.0], "timeout_s": 0.1}]}
)


class Still(Policy):
    robot = "ant"

    def __init__(self, *groups: str) -> None:
        self._groups = groups

    @property
    def observation_layout(self) -> tuple[str, ...]:
        return self._groups

    @property
    def reward_weights(self) -> dict[str, float]:
        return {"uprightness": 0.5}

    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.zeros((len(observation), 8))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plugins")
    (folder / "terms.py").write_text(PLUGIN)
    (folder / "other").mkdir()
    (folder / "other" / "terms.py").write_text(f"{PLUGIN}\n# another\n")
    (folder / "renamed.py").write_text(PLUGIN)
    (folder / "unused.py").write_text(PLUGIN.replace("half_height", "a_height").replace("uprightness", "another"))
    fly(MISSION, Still("height", "half_height"), log=folder / "group.mcap", plugins=folder / "terms.py")
    fly(MISSION, Still("height"), log=folder / "term.mcap", plugins=[folder / "terms.py", folder / "unused.py"])
    fly(MISSION, Still("height"), log=folder / "none.mcap")
    return folder


@pytest.mark.parametrize("log", ["group.mcap", "term.mcap"])
@pytest.mark.parametrize("given", ["terms.py", "renamed.py"])
def test_it_is_verified_with_the_plugin(folder: Path, log: str, given: str) -> None:
    assert open_log(folder / log).metadata["sha256_plugin/terms.py"] == SHA256
    assert verify(folder / log, folder / given).verdict is Verdict.EQUIVALENT


@pytest.mark.parametrize("log", ["group.mcap", "term.mcap"])
def test_without_it_the_log_is_unverifiable_and_names_it(folder: Path, log: str) -> None:
    found = verify(folder / log)
    assert found.verdict is Verdict.UNVERIFIABLE
    assert "the plugin terms.py was not given" in found.reason
    assert f"se --plugin terms.py (SHA-256 {SHA256})" in found.reason
    with pytest.raises(LogError, match=SHA256), unfinished_copy(folder / log):
        pass


def unfinished_copy(log: Path) -> AbstractContextManager[Unfinished | None]:
    part = log.with_name(f"cut-{log.name}.part")
    part.write_bytes(log.read_bytes()[:-3000])
    return unfinished(part)


@pytest.mark.parametrize("log", ["group.mcap", "term.mcap"])
def test_another_content_is_unverifiable_with_both_hashes(folder: Path, log: str) -> None:
    found = verify(folder / log, folder / "other" / "terms.py")
    assert found.verdict is Verdict.UNVERIFIABLE
    given = hashlib.sha256((folder / "other" / "terms.py").read_bytes()).hexdigest()
    assert f"terms.py has SHA-256 {given}, the log needs {SHA256}" in found.reason
    assert "ive that file with --plugin" in found.reason


def test_a_plugin_that_the_flight_did_not_use_changes_nothing(folder: Path) -> None:
    assert not [key for key in open_log(folder / "none.mcap").metadata if "plugin" in key]
    assert verify(folder / "none.mcap", folder / "terms.py").verdict is Verdict.EQUIVALENT
    given = [folder / "unused.py", folder / "terms.py"]
    assert verify(folder / "group.mcap", given).verdict is Verdict.EQUIVALENT


def test_a_group_of_no_file_is_named_and_given_in_any_form(folder: Path, tmp_path: Path) -> None:
    group = observation_group(name="half_height", unit="m", components=["half_height"])(lambda view: view.height / 2)
    fly(MISSION, Still("half_height"), log=tmp_path / "a.mcap", plugins=group)
    assert open_log(tmp_path / "a.mcap").metadata["plugins_not_of_a_file"] == "half_height"
    found = verify(tmp_path / "a.mcap")
    assert found.verdict is Verdict.UNVERIFIABLE
    assert "'half_height'" in found.reason
    assert verify(tmp_path / "a.mcap", [group]).verdict is Verdict.EQUIVALENT
    assert verify(tmp_path / "a.mcap", load_plugins(folder / "terms.py")).verdict is Verdict.EQUIVALENT
