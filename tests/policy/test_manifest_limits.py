"""What a manifest may say, up to its limits."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from waypointctl.errors import InputError, PolicyError
from waypointctl.policy.bundle import LoadedPolicy, load_policy, policy_of
from waypointctl.policy.manifest import Manifest
from waypointctl.policy.manifest_file import LARGEST_MANIFEST, other_policy_hint, read_manifest

Change = Callable[[dict[str, Any]], object]
SHA256 = "0" * 64


@pytest.fixture
def folder(tmp_path: Path, make_policy: Callable[..., LoadedPolicy]) -> Path:
    make_policy(tmp_path / "tiny")
    return tmp_path / "tiny"


def changed(folder: Path, change: Change) -> Manifest:
    path = folder / "manifest.json"
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))
    return read_manifest(folder)


def selected(**changes: object) -> Change:
    record = {"suite": "s", "seed": 0, "trials": 1, "successes": 0, "candidates": 1, "last_step": 0, "stop_at": None}
    return lambda content: content["training"].update(selection=record | changes)


def started(**changes: object) -> Change:
    record = {"policy": "p", "observation": "o", "steps": 0, "policy_sha256": SHA256, "weights_sha256": SHA256}
    return lambda content: content["training"].update(start=record | changes)


@pytest.mark.parametrize(
    "change",
    [
        lambda m: m.update(name="x" * 1000),
        lambda m: m.update(name="x"),
        lambda m: m.update(control_period_ns=1),
        lambda m: m.update(control_period_ns=10**15),
        lambda m: m["training"].update(steps=10**15),
        lambda m: m["training"].update(seed=2**63 - 1),
        lambda m: m["training"].update(wall_time_s=0.0),
        lambda m: m["action"].update(limits=[-1e-300, 0.0]),
        lambda m: m["network"].update(hidden_sizes=[1]),
        selected(),
        selected(stop_at=1.0),
        selected(stop_at=1e-300),
        started(),
    ],
)
def test_what_is_at_its_limit_is_read(folder: Path, change: Change) -> None:
    changed(folder, change)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (lambda m: m.update(name=""), "name"),
        (lambda m: m.update(control_period_ns=10**15 + 1), "control_period_ns"),
        (lambda m: m["observation"]["scales"].__setitem__(0, math.inf), "observation.scales.0"),
        (lambda m: m["observation"]["scales"].__setitem__(0, "1.0"), "observation.scales.0"),
        (lambda m: m["action"].update(size=0), "action.size"),
        (lambda m: m["action"].update(limits=[1.0, 1.0]), "action"),
        (lambda m: m["network"].update(hidden_sizes=[0]), "network.hidden_sizes.0"),
        (lambda m: m["training"].update(steps=-1), "training.steps"),
        (lambda m: m["training"].update(steps=10**15 + 1), "training.steps"),
        (lambda m: m["training"].update(seed=-1), "training.seed"),
        (lambda m: m["training"].update(seed=2**63), "training.seed"),
        (lambda m: m["training"].update(wall_time_s=-1e-9), "training.wall_time_s"),
        (lambda m: m["training"].update(versions={"": "1"}), "training.versions"),
        (selected(stop_at=0.0), "training.selection.stop_at"),
        (selected(stop_at=1.0000001), "training.selection.stop_at"),
        (selected(trials=0), "training.selection.trials"),
        (started(policy_sha256="0" * 63), "training.start.policy_sha256"),
        (lambda m: m["files"]["policy.onnx"].update(sha256="0" * 65), "files.`policy.onnx`.sha256"),
    ],
)
def test_what_is_beyond_its_limit_is_refused(folder: Path, change: Change, field: str) -> None:
    with pytest.raises(PolicyError) as caught:
        changed(folder, change)
    assert field.replace("`", "") in str(caught.value)


def test_a_weight_may_be_without_a_cap(folder: Path) -> None:
    manifest = changed(folder, lambda content: content["reward"].update(fall="Infinity"))
    assert manifest.reward["fall"] == math.inf
    assert '"fall":"Infinity"' in manifest.model_dump_json()


def test_a_manifest_cannot_be_changed(folder: Path) -> None:
    manifest = read_manifest(folder)
    with pytest.raises(ValidationError):
        manifest.name = "another"  # type: ignore[misc]


@pytest.mark.parametrize(("extra", "is_read"), [(0, True), (1, False)])
def test_a_manifest_has_a_mebibyte_at_most(folder: Path, extra: int, is_read: bool) -> None:
    path = folder / "manifest.json"
    path.write_text(path.read_text().ljust(2**20 + extra))
    assert LARGEST_MANIFEST == 2**20
    if is_read:
        read_manifest(folder)
    else:
        with pytest.raises(PolicyError, match="manifest"):
            read_manifest(folder)


def test_a_policy_is_given_as_itself_or_by_its_folder(folder: Path) -> None:
    policy = load_policy(folder)
    assert policy_of(policy) is policy
    assert policy_of(folder).name == policy_of(str(folder)).name == policy.name
    with pytest.raises(InputError, match="policy"):
        policy_of(3)  # type: ignore[arg-type]


@pytest.mark.parametrize("threads", [-1, 1025])
def test_a_number_of_threads_is_bounded(folder: Path, threads: int) -> None:
    assert load_policy(folder, threads=0).name == "tiny"
    with pytest.raises(InputError, match="threads"):
        load_policy(folder, threads=threads)


def test_an_empty_folder_is_no_damaged_policy(tmp_path: Path) -> None:
    with pytest.raises(PolicyError) as caught:
        load_policy(tmp_path)
    assert str(caught.value).startswith(f"{tmp_path}: no manifest.json")
    assert "copy the whole folder again" not in str(caught.value)


def test_of_keys_that_occur_twice_the_first_letters_are_named(folder: Path) -> None:
    key = "k" * 300
    (folder / "manifest.json").write_text(f'{{"{key}": 1, "{key}": 2}}')
    with pytest.raises(PolicyError, match=f"the keys {'k' * 200} occurs twice"):
        read_manifest(folder)


def test_a_manifest_over_its_limit_is_refused_although_it_is_json(folder: Path) -> None:
    manifest = folder / "manifest.json"
    manifest.write_bytes(manifest.read_bytes() + b" " * LARGEST_MANIFEST)
    with pytest.raises(PolicyError) as refused:
        load_policy(folder)
    assert "manifest.json" in str(refused.value)
    assert "1 MiB" in str(refused.value)


def test_a_folder_of_policies_names_the_policies_in_it(
    make_policy: Callable[..., LoadedPolicy], tmp_path: Path
) -> None:
    make_policy(tmp_path / "runs" / "mine")
    with pytest.raises(PolicyError) as refused:
        load_policy(tmp_path / "runs")
    assert "mine" in (refused.value.hint or "")


def test_a_hint_for_a_robot_lists_policies_only_where_one_is_for_it() -> None:
    assert "waypointctl policies" in other_policy_hint("ant")
    assert "waypointctl policies" not in other_policy_hint("no-such-robot")
