"""Policies to test with: whole bundles with small networks of random weights."""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from numpy.typing import NDArray
from safetensors.numpy import save
from xdist.scheduler import LoadFileScheduling

from tests.budget import examples
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import (
    ActionSpec,
    NetworkSpec,
    ObservationSpec,
    PolicyDescription,
    TrainingRecord,
)
from waypointctl.policy.write import mlp_to_onnx, write_bundle
from waypointctl.robots.load import load_robot
from waypointctl.robots.robot import Robot
from waypointctl.task.observation import layout

# The torch that has CUDA brings Triton, whose LLVM crashes the process where that of Mesa's software renderer has been
# loaded before it. Here one process draws and trains; the other way round they get along.
with contextlib.suppress(ImportError):
    importlib.import_module("triton")

FloatArray = NDArray[np.float64]

settings.register_profile("tests", max_examples=examples(100), deadline=None)
settings.load_profile("tests")

# Files whose tests take longest in all begin first, so that no process is left alone with one of them at the end.
_FIRST = (
    "tests/golden/test_golden.py",
    "tests/cli/test_train_command.py",
    "tests/test_examples.py",
    "tests/replay/test_resume.py",
)
_SHARING = ("tests/golden/test_golden.py", "tests/replay/test_verify.py", "tests/flight/test_mission_library.py")


class ByFile(LoadFileScheduling):  # type: ignore[misc]
    """The tests of a file run in one process, which makes their fixtures once; so do files that share flights."""

    def _split_scope(self, nodeid: str) -> str:
        file = nodeid.partition("::")[0]
        return _SHARING[0] if file in _SHARING else file


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> ByFile:
    """Let files run in the order in which they are collected: see `pytest_collection_modifyitems`."""
    config.option.loadscopereorder = False
    return ByFile(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the slowest files first."""
    order = {file: number for number, file in enumerate(_FIRST)}
    items.sort(key=lambda item: order.get(item.nodeid.partition("::")[0], len(order)))


@dataclass(frozen=True)
class RandomNetwork:
    """An ELU network with its normaliser, as float64 arrays."""

    layers: list[tuple[FloatArray, FloatArray]]
    mean: FloatArray
    variance: FloatArray

    def to_onnx(self) -> bytes:
        return mlp_to_onnx(self.layers, "elu", self.mean, self.variance, clip=10.0, epsilon=1e-8)

    def to_safetensors(self) -> bytes:
        arrays = {"mean": self.mean, "variance": self.variance}
        for i, (weight, bias) in enumerate(self.layers):
            arrays |= {f"{i}.weight": weight, f"{i}.bias": bias}
        return save(arrays)


def random_network(sizes: tuple[int, ...], seed: int = 0, gain: float = 1.0) -> RandomNetwork:
    """Draw a network; `gain` scales its actions, and 0 makes it stand with its motors off."""
    rng = np.random.default_rng(seed)
    layers = [
        (rng.normal(size=(out, into)) / np.sqrt(into), 0.1 * rng.normal(size=out)) for into, out in pairwise(sizes)
    ]
    weight, bias = layers[-1]
    layers[-1] = (gain * weight, gain * bias)
    return RandomNetwork(layers, 0.1 * rng.normal(size=sizes[0]), rng.uniform(0.5, 2.0, sizes[0]))


def observation_of(robot: Robot) -> ObservationSpec:
    """Return the egocentric layout of a robot, as a manifest has it."""
    seen = layout("egocentric", robot)
    return ObservationSpec.of(seen.name, seen.groups, seen.components)


def describe(**changes: object) -> PolicyDescription:
    """Describe a policy for the ant in the egocentric layout, but for `changes`."""
    description = PolicyDescription(
        name="tiny",
        robot="ant",
        control_period_ns=20_000_000,
        observation=observation_of(load_robot("ant")),
        action=ActionSpec(size=8, meaning="motor torque as a fraction of full torque", limits=(-1.0, 1.0)),
        network=NetworkSpec(hidden_sizes=(8, 8), activation="elu"),
        reward={"progress": 1.0, "fall": 200.0},
        training=TrainingRecord(
            algorithm="none",
            recipe="random weights",
            recipe_sha256="0" * 64,
            seed=0,
            steps=0,
            wall_time_s=0.0,
            versions={"mujoco": "3.14.0", "numpy": "2.4.6"},
        ),
    )
    return description.model_copy(update=changes)


@pytest.fixture(scope="session")
def make_policy() -> Callable[..., LoadedPolicy]:
    """Write a bundle of random weights: make_policy(folder, seed=0, gain=1.0, **changes to its description)."""

    def make(folder: Path, *, seed: int = 0, gain: float = 1.0, **changes: object) -> LoadedPolicy:
        network = random_network((31, 8, 8, 8), seed, gain)
        return write_bundle(folder, describe(**changes), network.to_onnx(), network.to_safetensors())

    return make
