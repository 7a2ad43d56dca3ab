from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from waypointctl.errors import OutputError, PolicyError
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.write import write_bundle

Make = Callable[..., LoadedPolicy]
BUNDLE = {"manifest.json", "policy.onnx", "weights.safetensors"}


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_the_same_policy_gives_the_same_bytes(tmp_path: Path, make_policy: Make) -> None:
    assert make_policy(tmp_path / "a").files == make_policy(tmp_path / "b").files


def test_it_makes_the_folder_and_leaves_nothing_else(tmp_path: Path, make_policy: Make) -> None:
    written = make_policy(tmp_path / "deep" / "down" / "tiny")
    assert names(tmp_path / "deep" / "down") == {"tiny"}
    assert names(tmp_path / "deep" / "down" / "tiny") == BUNDLE
    assert load_policy(tmp_path / "deep" / "down" / "tiny").files == written.files


def test_it_replaces_a_bundle_and_keeps_the_recipe_beside_it(tmp_path: Path, make_policy: Make) -> None:
    make_policy(tmp_path / "tiny", seed=0)
    (tmp_path / "tiny" / "train.yaml").write_text("name: tiny\n")
    second = make_policy(tmp_path / "tiny", seed=1)
    assert load_policy(tmp_path / "tiny").sha256 == second.sha256
    assert names(tmp_path) == {"tiny"}
    assert names(tmp_path / "tiny") == BUNDLE | {"train.yaml"}


def test_interrupted_between_two_files_the_mixture_is_refused(
    tmp_path: Path, make_policy: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_policy(tmp_path / "tiny", seed=0)
    replace = Path.replace

    def power_cut(self: Path, target: Any) -> Path:
        if self.name == "manifest.json":
            raise KeyboardInterrupt
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", power_cut)
    with pytest.raises(KeyboardInterrupt):
        make_policy(tmp_path / "tiny", seed=1)
    assert names(tmp_path) == {"tiny"}
    with pytest.raises(PolicyError, match="altered"):
        load_policy(tmp_path / "tiny")


def test_a_network_that_does_not_fit_is_not_written(tmp_path: Path, make_policy: Make) -> None:
    good = make_policy(tmp_path / "good")
    description = good.manifest.model_copy(update={"action": good.manifest.action.model_copy(update={"size": 12})})
    with pytest.raises(PolicyError, match="31 observations and 12 actions"):
        write_bundle(tmp_path / "bad", description, good.files["policy.onnx"], good.files["weights.safetensors"])
    assert names(tmp_path) == {"good"}


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path, make_policy: Make) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"file/tiny: the policy cannot be written: Not a directory\n  Use a folder"):
        make_policy(tmp_path / "file" / "tiny")
    with pytest.raises(OutputError, match=r"file: the policy cannot be written: Not a directory"):
        make_policy(tmp_path / "file")
    assert names(tmp_path) == {"file"}


def test_a_cap_that_is_none_survives_as_plain_json(tmp_path: Path, make_policy: Make) -> None:
    make_policy(tmp_path / "tiny", reward={"progress": 1.0, "progress_cap_mps": np.inf})

    def refuse(constant: str) -> float:
        raise AssertionError(f"{constant} is not JSON")

    json.loads((tmp_path / "tiny" / "manifest.json").read_text(), parse_constant=refuse)
    assert load_policy(tmp_path / "tiny").reward_weights == {"progress": 1.0, "progress_cap_mps": np.inf}
