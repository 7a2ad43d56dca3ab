"""Models of stable-baselines3 as people have them: trained a little, saved, with a VecNormalize file beside."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from waypointctl.task.config import TaskConfig
from waypointctl.task.env import WaypointEnv

torch.set_num_threads(1)  # networks this small only wait for more


def normalised_env(observation: str = "egocentric", **options: Any) -> VecNormalize:
    """Return WaypointEnv behind a VecNormalize that has seen some observations."""
    config = TaskConfig(observation=observation)
    env = VecNormalize(DummyVecEnv([lambda: WaypointEnv(config)]), **options)
    env.seed(1)
    env.reset()
    rng = np.random.default_rng(1)
    for _ in range(30):
        env.step(rng.uniform(-1.0, 1.0, (1, 8)).astype(np.float32))
    return env


def strengthened(model: BaseAlgorithm, factor: float = 20.0) -> BaseAlgorithm:
    """Return the model with larger weights, so that its actions reach the limits and its hidden layers saturate."""
    with torch.no_grad():
        for name, parameter in model.policy.named_parameters():
            if name.endswith("weight"):
                parameter.mul_(factor if "action_net" in name else 1.5)
            elif name.endswith("bias"):
                parameter.add_(0.3 * torch.randn(parameter.shape, generator=torch.Generator().manual_seed(3)))
    return model


def observations(normaliser: VecNormalize | None, size: int, n: int = 300) -> NDArray[np.float32]:
    """Draw observations (n, size), some beyond the normaliser's clip."""
    drawn = np.random.default_rng(5).normal(scale=4.0, size=(n, size))
    if normaliser is not None:
        statistics: Any = normaliser.obs_rms
        drawn = statistics.mean + drawn * np.sqrt(statistics.var)
    return drawn.astype(np.float32)


def rewritten(model: Path, copy: Path, **settings: Any) -> Path:
    """Copy a saved model with other settings in its JSON."""
    return with_parts(model, copy, data=json.dumps(json.loads(part(model, "data")) | settings).encode())


def with_parts(model: Path, copy: Path, **parts: bytes | None) -> Path:
    """Copy a saved model with other content of its parts, or without them; `policy` is policy.pth."""
    names = {"policy": "policy.pth"}
    changed = {names.get(name, name): content for name, content in parts.items()}
    with zipfile.ZipFile(model) as old, zipfile.ZipFile(copy, "w") as new:
        for name in old.namelist():
            content = changed.get(name, old.read(name))
            if content is not None:
                new.writestr(name, content)
    return copy


def part(model: Path, name: str) -> bytes:
    """Return a part of a saved model."""
    with zipfile.ZipFile(model) as archive:
        return archive.read(name)
