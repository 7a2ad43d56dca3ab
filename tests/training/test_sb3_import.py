"""What an imported policy does is what stable-baselines3 does with the same files."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from safetensors.numpy import load
from stable_baselines3 import A2C, PPO, SAC, TD3
from stable_baselines3.common.vec_env import VecNormalize

from tests.training.sb3_models import normalised_env, observations, strengthened
from waypointctl.errors import InputError, OutputError
from waypointctl.policy.bundle import load_policy
from waypointctl.task.config import TaskConfig
from waypointctl.task.env import WaypointEnv
from waypointctl.training.sb3_import import Imported, import_sb3

SMALL = {"net_arch": [16, 12]}
KINDS: dict[str, tuple[Any, dict[str, Any]]] = {
    "PPO": (PPO, {"policy_kwargs": SMALL | {"activation_fn": torch.nn.ELU}, "n_steps": 64, "batch_size": 32}),
    "PPO gSDE": (PPO, {"policy_kwargs": SMALL | {"activation_fn": torch.nn.ReLU}, "use_sde": True, "n_steps": 64}),
    "PPO squashed": (
        PPO,
        {"policy_kwargs": SMALL | {"squash_output": True, "full_std": False}, "use_sde": True, "n_steps": 64},
    ),
    "PPO linear": (PPO, {"policy_kwargs": {"net_arch": []}, "n_steps": 64}),
    "PPO uneven": (PPO, {"policy_kwargs": {"net_arch": {"pi": [8, 9, 10], "vf": [5]}}, "n_steps": 64}),
    "A2C": (A2C, {}),
    "SAC": (SAC, {"policy_kwargs": SMALL | {"n_critics": 3}, "buffer_size": 100}),
    "TD3": (TD3, {"policy_kwargs": {"net_arch": {"pi": [16, 12], "qf": [6]}}, "buffer_size": 100}),
}


@pytest.mark.parametrize(("kind", "normalised"), [*((kind, True) for kind in KINDS), ("PPO", False)])
def test_it_acts_as_stable_baselines3_does(tmp_path: Path, kind: str, normalised: bool) -> None:
    algorithm, options = KINDS[kind]
    env = normalised_env(clip_obs=2.5, epsilon=1e-3)
    model = strengthened(algorithm("MlpPolicy", env if normalised else WaypointEnv(), seed=1, device="cpu", **options))
    model.save(tmp_path / "model.zip")
    env.save(str(tmp_path / "normaliser.pkl"))

    imported = import_sb3(
        tmp_path / "model.zip",
        tmp_path / "mine",
        robot="ant",
        observation="egocentric",
        vecnormalize=tmp_path / "normaliser.pkl" if normalised else None,
    )

    seen = observations(env if normalised else None, 31)
    expected, _ = algorithm.load(tmp_path / "model.zip", device="cpu").predict(
        np.asarray(env.normalize_obs(seen)) if normalised else seen, deterministic=True
    )
    actions = np.clip(load_policy(tmp_path / "mine").act(seen.astype(np.float64)), -1.0, 1.0)
    np.testing.assert_allclose(actions, expected, atol=1e-5)
    assert np.ptp(expected, axis=0).min() > 0.05, "the actions depend on the observations"
    assert imported.difference < 1e-5
    assert imported.policy.manifest.training.algorithm.startswith(kind.split()[0])


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with model.zip, a PPO that has been trained, and normaliser.pkl."""
    folder = tmp_path_factory.mktemp("saved")
    env = normalised_env()
    model = PPO("MlpPolicy", env, n_steps=64, batch_size=32, policy_kwargs=SMALL, seed=11, device="cpu")
    model.learn(128)
    model.save(folder / "model.zip")
    env.save(str(folder / "normaliser.pkl"))
    return folder


def imported_from(saved: Path, out: Path, **changes: Any) -> Imported:
    arguments: dict[str, Any] = {
        "robot": "ant",
        "observation": "egocentric",
        "vecnormalize": saved / "normaliser.pkl",
    }
    return import_sb3(saved / "model.zip", out, **(arguments | changes))


def test_the_manifest_says_where_it_comes_from(saved: Path, tmp_path: Path) -> None:
    manifest = imported_from(saved, tmp_path / "mine").policy.manifest
    model, normaliser = ((saved / name).read_bytes() for name in ("model.zip", "normaliser.pkl"))
    record = manifest.training
    assert record.recipe_sha256 == hashlib.sha256(model).hexdigest()
    assert record.recipe == (
        f"imported from model.zip, with a VecNormalize file of SHA-256 {hashlib.sha256(normaliser).hexdigest()}"
    )
    assert (record.seed, record.steps, record.wall_time_s) == (11, 128, 0.0)
    assert record.versions.keys() == {"waypointctl", "stable-baselines3"}
    assert (manifest.name, manifest.robot, manifest.control_period_ns) == ("mine", "ant", 20_000_000)
    assert (manifest.network.hidden_sizes, manifest.network.activation) == ((16, 12), "tanh")


def test_every_tensor_and_the_normaliser_are_among_the_weights(saved: Path, tmp_path: Path) -> None:
    weights = load(imported_from(saved, tmp_path / "mine").policy.files["weights.safetensors"])
    for name, tensor in PPO.load(saved / "model.zip", device="cpu").policy.state_dict().items():
        np.testing.assert_array_equal(weights.pop(name), tensor.numpy())
    env = VecNormalize.load(str(saved / "normaliser.pkl"), normalised_env().venv)
    statistics: Any = env.obs_rms
    np.testing.assert_array_equal(weights["normaliser.mean"], statistics.mean)
    np.testing.assert_array_equal(weights["normaliser.var"], statistics.var)
    assert weights["normaliser.count"] == statistics.count


def test_another_layout_of_the_same_robot(tmp_path: Path) -> None:
    model = PPO("MlpPolicy", WaypointEnv(TaskConfig(observation="state_goal")), n_steps=64, device="cpu")
    model.save(tmp_path / "model.zip")
    policy = imported_from(tmp_path, tmp_path / "mine", observation="state_goal", vecnormalize=None).policy
    assert (policy.observation_layout, policy.manifest.observation.size) == ("state_goal", 29)


def test_a_policy_that_is_there_is_replaced_only_on_request(saved: Path, tmp_path: Path) -> None:
    first = imported_from(saved, tmp_path / "mine", vecnormalize=None).policy
    (tmp_path / "mine" / "evaluation.json").write_text("{}")
    with pytest.raises(OutputError, match=r"mine: is a policy already\n  .*--force"):
        imported_from(saved, tmp_path / "mine")
    assert load_policy(tmp_path / "mine").sha256 == first.sha256
    second = imported_from(saved, tmp_path / "mine", force=True).policy
    assert load_policy(tmp_path / "mine").sha256 == second.sha256 != first.sha256
    assert not (tmp_path / "mine" / "evaluation.json").exists(), "it was of the policy before"


def test_a_folder_of_something_else_is_never_written_into(saved: Path, tmp_path: Path) -> None:
    (tmp_path / "thesis").mkdir()
    (tmp_path / "thesis" / "chapter.tex").write_text("...")
    with pytest.raises(OutputError, match="already exists and is not a policy"):
        imported_from(saved, tmp_path / "thesis", force=True)
    assert [path.name for path in tmp_path.rglob("*")] == ["thesis", "chapter.tex"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"observation": "state_goal"}, r"maps 31 observations to 8 actions, not 29 to 8"),
        ({"observation": "camera"}, "unknown observation layout 'camera'"),
        ({"robot": "dog"}, "there is no robot 'dog'"),
        ({"vecnormalize": Path("nowhere.pkl")}, "nowhere.pkl: there is no such file"),
    ],
)
def test_what_does_not_fit_is_refused_and_nothing_is_written(
    saved: Path, tmp_path: Path, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        imported_from(saved, tmp_path / "mine", **changes)
    assert not list(tmp_path.iterdir())
