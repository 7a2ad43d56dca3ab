"""Models and normalisers that are not what can be imported, some of them malicious."""

from __future__ import annotations

import base64
import io
import os
import pickle
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import torch
from stable_baselines3 import DQN, PPO, SAC
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.torch_layers import FlattenExtractor

from tests.training.sb3_models import normalised_env, rewritten, with_parts
from waypointctl.errors import PolicyError
from waypointctl.importers.stable_baselines3.archive import read_archive, read_normaliser
from waypointctl.importers.stable_baselines3.network import read_network
from waypointctl.task.env import WaypointEnv
from waypointctl.training.sb3_import import build_policy, import_sb3


class Malicious:
    """Loading it makes a folder."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> Any:
        return (os.mkdir, (str(self.path),))


class OwnPolicy(ActorCriticPolicy):
    """A policy of one's own, which may compute anything."""


class OwnExtractor(FlattenExtractor):
    """It has no weights, so that no tensor gives it away."""


class Doubled(gymnasium.ActionWrapper[Any, Any, Any]):
    """Actions in [-2, 2]."""

    def __init__(self) -> None:
        super().__init__(WaypointEnv())
        self.action_space = gymnasium.spaces.Box(-2.0, 2.0, (8,), np.float32)


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.zip"
    return save_ppo(path, net_arch=[8])


def save_ppo(path: Path, policy: Any = "MlpPolicy", env: Any = None, **policy_kwargs: Any) -> Path:
    PPO(policy, env or WaypointEnv(), n_steps=64, policy_kwargs=policy_kwargs, device="cpu").save(path)
    return path


def build(path: Path) -> None:
    archive = read_archive(path)
    build_policy(archive, read_network(archive, 31, 8))


def refused(path: Path, message: str) -> None:
    with pytest.raises(PolicyError, match=message) as caught:
        build(path)
    assert str(path) in str(caught.value)


def test_pickles_in_a_model_are_not_loaded(model: Path, tmp_path: Path) -> None:
    victim = tmp_path / "victim"
    pickled = pickle.dumps(Malicious(victim))
    serialised = base64.b64encode(pickled).decode()
    bad = rewritten(model, tmp_path / "bad.zip", lr_schedule={":type:": "x", ":serialized:": serialised})
    build(bad)
    assert not victim.exists()
    pickle.loads(pickled)
    assert victim.exists(), "the pickle is a working one"


@pytest.mark.parametrize("whole", [True, False])
def test_a_pickle_in_the_place_of_the_tensors_is_refused_and_not_loaded(
    model: Path, tmp_path: Path, whole: bool
) -> None:
    victim = tmp_path / "victim"
    buffer = io.BytesIO()
    torch.save({"action_net.weight": Malicious(victim)}, buffer)
    content = buffer.getvalue() if whole else pickle.dumps(Malicious(victim))
    refused(with_parts(model, tmp_path / "bad.zip", policy=content), "nothing of it was executed")
    assert not victim.exists()


def test_other_kinds_of_policy_are_refused_by_name(tmp_path: Path) -> None:
    path = tmp_path / "model.zip"
    DQN("MlpPolicy", "CartPole-v1", buffer_size=10, device="cpu").save(path)
    refused(path, r"its policy is stable_baselines3\.dqn\.policies\.DQNPolicy; what can be imported: ActorCritic")
    refused(save_ppo(path, OwnPolicy), r"its policy is [\w.]*test_sb3_refused; what can")
    refused(save_ppo(path, features_extractor_class=OwnExtractor), r"features extractor is .*OwnExtractor")
    refused(save_ppo(path, activation_fn=torch.nn.LeakyReLU), r"its activation is LeakyReLU; a policy's is ELU, Tanh")
    SAC("MlpPolicy", WaypointEnv(), buffer_size=10, use_sde=True, device="cpu").save(path)
    refused(path, "gSDE")


def test_other_actions_and_other_sizes_are_refused(model: Path, tmp_path: Path) -> None:
    path = tmp_path / "other.zip"
    refused(save_ppo(path, env=Doubled()), r"the low of its actions is .*-2.*; a policy's actions are in \[-1, 1\]")
    refused(rewritten(model, path, action_space=None), "the low of its actions is missing")
    refused(save_ppo(path, env=gymnasium.make("Pendulum-v1")), "the low of its actions")
    with pytest.raises(PolicyError, match="maps 31 observations to 8 actions, not 31 to 12"):
        read_network(read_archive(model), 31, 12)


def test_tensors_that_have_no_place_or_are_not_finite_are_refused(model: Path, tmp_path: Path) -> None:
    tensors = {name: torch.from_numpy(array) for name, array in read_archive(model).tensors.items()}
    for name, value, message in (
        ("mlp_extractor.shared_net.0.weight", torch.zeros(3, 3), "not a plain multilayer perceptron: Unexpected key"),
        ("action_net.weight", torch.full((8, 8), torch.nan), "action_net.weight is not an array of finite numbers"),
        ("action_net.weight", torch.zeros(8, 8, dtype=torch.int64), "is not an array of finite numbers"),
        ("action_net.weight", torch.zeros(8, 9), "not a plain multilayer perceptron: size mismatch"),
        ("mlp_extractor.value_net.2.weight", torch.zeros(2**22, 1), "not a plain multilayer perceptron: size mismatch"),
        ("action_net.weight", torch.zeros(8), "not a plain multilayer perceptron|maps 31 observations"),
    ):
        buffer = io.BytesIO()
        torch.save(tensors | {name: value}, buffer)
        refused(with_parts(model, tmp_path / "bad.zip", policy=buffer.getvalue()), message)


def test_settings_that_do_not_fit_together_are_refused(model: Path, tmp_path: Path) -> None:
    bad = rewritten(model, tmp_path / "bad.zip", policy_kwargs={"squash_output": True})
    refused(bad, "not a plain multilayer perceptron: squash_output=True is only available")
    tensors = {name: torch.from_numpy(array) for name, array in read_archive(model).tensors.items()}
    buffer = io.BytesIO()
    torch.save(tensors | {"log_std": torch.full((8,), -1e4)}, buffer)
    bad = with_parts(model, tmp_path / "bad.zip", policy=buffer.getvalue())
    with pytest.raises(PolicyError, match=r"bad\.zip: stable-baselines3 itself cannot act with it"):
        import_sb3(bad, tmp_path / "out", robot="ant", observation="egocentric")
    assert not (tmp_path / "out").exists()


def test_what_is_no_model_is_refused(model: Path, tmp_path: Path) -> None:
    bad = tmp_path / "bad.zip"
    refused(bad, "there is no such file")
    refused(tmp_path, "is a folder, not a file")
    bad.write_text("hello")
    refused(bad, "not a .zip that can be read: File is not a zip file")
    bad.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n")
    refused(bad, "is a Git LFS pointer, not the file itself")
    bad.write_bytes(model.read_bytes()[:-300])
    refused(bad, "not a .zip that can be read|no data in it")  # a .pth is a .zip as well
    refused(with_parts(model, bad, data=None), "no data in it")
    refused(with_parts(model, bad, policy=None), r"no policy\.pth in it")
    refused(with_parts(model, bad, data=b"{"), "bad.zip/data: not JSON")
    refused(with_parts(model, bad, data=b"[" * 100_000), "bad.zip/data: not JSON")
    refused(with_parts(model, bad, data=b"[]"), "not a JSON object")
    refused(with_parts(model, bad, data=b"{}"), "its policy is unknown")


def test_a_damaged_byte_is_found(model: Path, tmp_path: Path) -> None:
    content = bytearray(model.read_bytes())
    content[content.index(b"policy.pth") + 2000] ^= 1
    bad = tmp_path / "bad.zip"
    bad.write_bytes(content)
    refused(bad, "Bad CRC-32")


def test_a_normaliser_that_is_none_is_refused(tmp_path: Path) -> None:
    path, victim = tmp_path / "n.pkl", tmp_path / "victim"
    env = normalised_env()
    state: dict[str, Any] = env.__getstate__()
    for content, message in (
        (b"hello", "not a file of VecNormalize: it is not a pickle"),
        (pickle.dumps([1]), "it holds another object"),
        (pickle.dumps(Malicious(victim)), "it holds another object"),
        (saved_state(state | {"obs_rms": {"a": 1}}), "no mean and variance of observations that are one array"),
        (saved_state(state | {"epsilon": 0.0}), "is not what it can be"),
        (saved_state(state | {"clip_obs": float("nan")}), "is not what it can be"),
        (saved_state(state | {"clip_obs": "10"}), "str is not an array of numbers"),
        (saved_state(state | {"clip_obs": np.array([1.0, 2.0])}), "not a file of VecNormalize"),
        (saved_state(state | {"epsilon": 10**400}), "not a file of VecNormalize"),
        (saved_state(state | {"epsilon": 1e300}), "is not what it can be"),
        (b"]r\xff\xff\xff\x7f.", "not a file of VecNormalize: it is not a pickle: it uses the memo index"),
    ):
        path.write_bytes(content)
        with pytest.raises(PolicyError, match=message):
            read_normaliser(path, 31)
    assert not victim.exists()
    env.save(str(path))
    with pytest.raises(PolicyError, match=r"normalises observations of shape \(31,\); the model takes 29"):
        read_normaliser(path, 29)


def saved_state(state: dict[str, Any]) -> bytes:
    """Return a VecNormalize pickle of another state."""
    env = normalised_env()
    env.__dict__.update(state)
    return pickle.dumps(env)


def test_a_vecnormalize_that_leaves_observations_alone_is_the_identity(tmp_path: Path) -> None:
    normalised_env(norm_obs=False).save(str(tmp_path / "n.pkl"))
    normaliser = read_normaliser(tmp_path / "n.pkl", 31)
    x = np.random.default_rng(0).normal(scale=1e6, size=(5, 31))
    np.testing.assert_allclose(normaliser.apply(x), x, rtol=1e-11)
    assert normaliser.sha256 == ""
