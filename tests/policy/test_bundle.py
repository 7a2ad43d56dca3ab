from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
from safetensors.numpy import load

from waypointctl.errors import PolicyError
from waypointctl.limits import VARIABLE, set_limits
from waypointctl.policy.bundle import LoadedPolicy, load_policy, load_policy_bytes
from waypointctl.policy.protocol import Policy

Make = Callable[..., LoadedPolicy]
Damage = Callable[[Path], object]


@pytest.fixture
def folder(tmp_path: Path, make_policy: Make) -> Path:
    make_policy(tmp_path / "tiny")
    return tmp_path / "tiny"


def test_the_limit_that_a_refusal_names_is_enough(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also for the other file of the bundle, which may be the larger one."""
    monkeypatch.setenv(VARIABLE, "policy-file=100")
    with pytest.raises(PolicyError, match=r"has [\d,]+ K?i?B; the limit policy-file is 100 B\n") as caught:
        load_policy(folder)
    set_limits(re.findall(r"--limit (\S+)", str(caught.value)))
    load_policy(folder)


def refusal(folder: Path) -> str:
    with pytest.raises(PolicyError) as caught:
        load_policy(folder)
    return str(caught.value)


def change_manifest(folder: Path, change: Callable[[dict[str, Any]], object]) -> None:
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text())
    change(manifest)
    path.write_text(json.dumps(manifest))


def replace_network(folder: Path, model: bytes) -> None:
    """Put another network into a bundle, and its hash into the manifest, as someone who means it would."""
    (folder / "policy.onnx").write_bytes(model)
    record = {"sha256": hashlib.sha256(model).hexdigest(), "size": len(model)}
    change_manifest(folder, lambda manifest: manifest["files"].update({"policy.onnx": record}))


def test_act_computes_what_the_weights_say(folder: Path) -> None:
    w = load((folder / "weights.safetensors").read_bytes())
    x = np.random.default_rng(1).normal(size=(5, 31))
    h = np.clip((x - w["mean"]) / np.sqrt(w["variance"] + 1e-8), -10.0, 10.0)
    for i in range(2):
        h = h @ w[f"{i}.weight"].T + w[f"{i}.bias"]
        h = np.where(h > 0, h, np.expm1(np.minimum(h, 0)))
    action = load_policy(folder).act(x)
    assert action.dtype == np.float64
    np.testing.assert_allclose(action, h @ w["2.weight"].T + w["2.bias"], atol=1e-5)


def test_act_gives_the_same_bits_again_and_in_any_batch_and_leaves_its_input_alone(folder: Path) -> None:
    x = np.random.default_rng(2).normal(size=(64, 31))
    given = x.copy()
    policy, again = load_policy(folder), load_policy(folder, threads=2)
    together = policy.act(x)
    np.testing.assert_array_equal(together, policy.act(x))
    np.testing.assert_array_equal(together, again.act(x))
    np.testing.assert_array_equal(together, np.vstack([policy.act(row[np.newaxis]) for row in x]))
    np.testing.assert_array_equal(x, given)


def test_what_act_returned_is_not_overwritten_by_the_next_call(folder: Path) -> None:
    policy = load_policy(folder)
    first = policy.act(np.zeros((1, 31)))
    kept = first.copy()
    second = policy.act(np.ones((1, 31)))
    np.testing.assert_array_equal(first, kept)
    assert not np.array_equal(first, second)


def test_it_is_what_a_flight_needs(folder: Path) -> None:
    policy: Policy = load_policy(folder)
    assert (policy.robot, policy.observation_layout) == ("ant", "egocentric")
    assert policy.reward_weights == {"progress": 1.0, "fall": 200.0}


def test_it_loads_again_from_the_bytes_that_it_gives(folder: Path) -> None:
    policy = load_policy(folder)
    assert set(policy.files) == {"manifest.json", "policy.onnx", "weights.safetensors"}
    again = load_policy_bytes(policy.files, "flight.mcap")
    assert again.manifest == policy.manifest
    assert again.sha256 == policy.sha256 == hashlib.sha256((folder / "manifest.json").read_bytes()).hexdigest()
    x = np.random.default_rng(3).normal(size=(3, 31))
    np.testing.assert_array_equal(again.act(x), policy.act(x))


def test_other_files_in_the_folder_are_none_of_its_business(folder: Path) -> None:
    sha256 = load_policy(folder).sha256
    (folder / "train.yaml").write_text("name: tiny\n")
    loaded = load_policy(folder)
    assert loaded.sha256 == sha256
    assert "train.yaml" not in loaded.files


def test_a_bundle_from_a_log_names_the_log(folder: Path) -> None:
    files = dict(load_policy(folder).files)
    del files["policy.onnx"]
    with pytest.raises(PolicyError, match=r"^flight\.mcap: no policy\.onnx; a policy has manifest\.json"):
        load_policy_bytes(files, "flight.mcap")


@pytest.mark.parametrize("name", ["manifest.json", "policy.onnx", "weights.safetensors"])
def test_a_missing_file_is_named(folder: Path, name: str) -> None:
    (folder / name).unlink()
    assert refusal(folder).startswith(f"{folder}: no {name}; a policy has")


def test_a_folder_that_is_not_there_is_named(tmp_path: Path) -> None:
    assert refusal(tmp_path / "none").startswith(f"{tmp_path / 'none'}: folder not found\n  A policy is a folder with")


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    (tmp_path / "policy.zip").write_bytes(b"PK")
    assert (
        "policy.zip: is a file, not a folder\n  A policy is a folder with manifest.json, or a name. There is"
        in refusal(tmp_path / "policy.zip")
    )


@pytest.mark.parametrize("name", ["policy.onnx", "weights.safetensors"])
@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda content: content[:-1], "truncated: it has"),
        (lambda content: b"", "truncated: it has 0 bytes, its manifest has"),
        (lambda content: content + b"\0", "altered: it has"),
        (lambda content: content[:-1] + bytes([content[-1] ^ 1]), "altered: its SHA-256 is not the manifest's"),
    ],
)
def test_a_damaged_file_is_named(folder: Path, name: str, damage: Callable[[bytes], bytes], message: str) -> None:
    path = folder / name
    path.write_bytes(damage(path.read_bytes()))
    assert refusal(folder).startswith(f"{path}: {message}")


@pytest.mark.parametrize("name", ["manifest.json", "policy.onnx", "weights.safetensors"])
def test_a_git_lfs_pointer_is_named_for_what_it_is(folder: Path, name: str) -> None:
    (folder / name).write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 153771\n")
    assert refusal(folder).startswith(f"{folder / name}: is a Git LFS pointer, not the file itself: fetch")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not JSON: Expecting value: line 1 column 1"),
        ('{"schema_version": 1,', "not JSON: "),
        ("\xff", "not JSON: "),
        ("[1, 2]", "must be an object with a whole number as schema_version"),
        ("{}", "must be an object with a whole number as schema_version"),
        ('{"schema_version": true}', "must be an object with a whole number as schema_version"),
        ('{"schema_version": 7}', "schema_version is 7; this waypointctl reads 2"),
        (
            '{"schema_version": 1, "name": "a", "name": "b"}',
            "not JSON: one of the keys schema_version, name occurs twice",
        ),
        ('{"schema_version": 2}', "name: Field required"),
    ],
)
def test_a_manifest_of_the_wrong_shape_is_refused(folder: Path, text: str, message: str) -> None:
    (folder / "manifest.json").write_bytes(text.encode("latin-1"))
    found = refusal(folder)
    assert found.startswith(f"{folder / 'manifest.json'}: ")
    assert message in found


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda m: m.update(author="me"), "author: Extra inputs are not permitted"),
        (lambda m: m.update(control_period_ns=0), "control_period_ns: Input should be greater than 0"),
        (lambda m: m.update(control_period_ns=10**400), "control_period_ns: Input should be less than or equal to"),
        (lambda m: m["training"].update(steps=10**30), "training.steps: Input should be less than or equal to"),
        (lambda m: m.update(name="x" * 1001), "name: String should have at most 1000 characters"),
        (lambda m: m.update(control_period_ns="20 ms"), "control_period_ns: Input should be a valid integer"),
        (lambda m: m["observation"]["names"].pop(), "observation: Value error, names has 30 entries, but size is 31"),
        (lambda m: m["observation"]["units"].pop(), "units has 30 entries"),
        (lambda m: m["observation"]["scales"].append(1.0), "scales has 32 entries"),
        (lambda m: m["action"].update(limits=[1.0, -1.0]), "limits [1.0, -1.0] must be [low, high]"),
        (lambda m: m["network"].update(activation="swish"), "network.activation: Input should be 'elu', 'tanh' or"),
        (lambda m: m["reward"].update(progress="much"), "reward.progress: Input should be a valid number"),
        (lambda m: m["training"].update(recipe_sha256="abc"), "training.recipe_sha256: String should match"),
        (lambda m: m["files"].pop("policy.onnx"), "files must be policy.onnx and weights.safetensors, not weights"),
        (lambda m: m["files"].update({"../run.py": m["files"]["policy.onnx"]}), "files must be policy.onnx and"),
    ],
)
def test_a_field_that_is_wrong_is_named(folder: Path, change: Callable[[dict[str, Any]], object], message: str) -> None:
    change_manifest(folder, change)
    assert message in refusal(folder)


def test_a_network_of_other_sizes_than_the_manifest_says_is_refused(folder: Path) -> None:
    change_manifest(folder, lambda m: m["action"].update(size=12))
    assert "the network maps 31 numbers to 8, but the manifest has 31 observations and 12 actions" in refusal(folder)


def test_a_network_that_someone_replaced_hash_and_all_is_still_examined(folder: Path) -> None:
    model = onnx.load_from_string((folder / "policy.onnx").read_bytes())
    model.graph.node[0].domain = "com.example"
    replace_network(folder, model.SerializeToString())
    assert f"{folder / 'policy.onnx'}: the model has operators of the domain 'com.example'" in refusal(folder)


def test_a_file_that_cannot_be_read_is_named(folder: Path) -> None:
    (folder / "policy.onnx").unlink()
    (folder / "policy.onnx").mkdir()
    assert refusal(folder) == f"{folder / 'policy.onnx'}: is a folder, not a file"


def test_a_manifest_nested_without_end_is_refused(folder: Path) -> None:
    (folder / "manifest.json").write_text("[" * 200_000)
    assert "manifest.json: not JSON: " in refusal(folder)


def test_a_folder_whose_name_is_too_long_is_refused() -> None:
    assert "cannot be read: File name too long" in refusal(Path("x" * 5000))
