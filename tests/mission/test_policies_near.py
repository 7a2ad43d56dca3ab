from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from waypointctl.errors import PolicyError
from waypointctl.mission import policy_name
from waypointctl.policy.bundle import LoadedPolicy, load_policy

NOTHING = "no manifest.json and no policy.onnx and no weights.safetensors; a policy has "


def hint_for(folder: Path) -> str:
    with pytest.raises(PolicyError, match=NOTHING) as caught:
        load_policy(folder)
    return str(caught.value.hint).replace(f"{folder}/", "")


def manifest(folder: Path, age_s: int) -> None:
    folder.mkdir(parents=True)
    (folder / "manifest.json").touch()
    os.utime(folder / "manifest.json", (1e9 - age_s, 1e9 - age_s))


def test_a_folder_of_runs_gets_its_newest_policies_named(tmp_path: Path) -> None:
    for age_s, name in enumerate(["d", "b", "e", "a", "c"]):
        manifest(tmp_path / name, age_s)
    (tmp_path / "unfinished" / "checkpoints").mkdir(parents=True)
    assert hint_for(tmp_path) == "Policies in it are d, b, e and 2 more: give one of these."


def test_a_run_without_a_policy_gets_its_checkpoints_named(tmp_path: Path) -> None:
    for steps in (10, 20):
        manifest(tmp_path / "checkpoints" / f"step-{steps}", 100 - steps)
    manifest(tmp_path / "checkpoints" / ".step-30.1.tmp", 0)
    assert hint_for(tmp_path) == "Policies in it are checkpoints/step-20, checkpoints/step-10: give one of these."


def test_the_only_policy_is_the_one_that_was_meant(tmp_path: Path, make_policy: Callable[..., LoadedPolicy]) -> None:
    make_policy(tmp_path / "group" / "seed-0")
    assert hint_for(tmp_path) == "Did you mean group/seed-0?"
    assert load_policy(tmp_path / "group" / "seed-0").manifest.name == "tiny"


def test_without_any_it_is_said_what_a_policy_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    manifest(tmp_path / "too" / "far" / "below", 0)
    assert hint_for(tmp_path).startswith("A policy is a folder with manifest.json, or a name. There is ")
    monkeypatch.setattr(policy_name, "_MOST_SEEN", 0)
    manifest(tmp_path / "beyond", 0)
    assert hint_for(tmp_path).startswith("A policy is a folder")


def test_a_damaged_policy_is_still_called_damaged(tmp_path: Path, make_policy: Callable[..., LoadedPolicy]) -> None:
    make_policy(tmp_path)
    make_policy(tmp_path / "whole")
    (tmp_path / "policy.onnx").unlink()
    with pytest.raises(PolicyError, match=r"no policy\.onnx; a policy has .*\n  Copy the whole folder again"):
        load_policy(tmp_path)
