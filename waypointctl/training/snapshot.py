"""A learner's whole state between an update and the next rollout, as arrays and plain facts, and back.

It holds weights, optimiser, normaliser, the state of every robot and of every random stream; what a learning rate
or a phase is follows from the step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import torch
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from waypointctl.training.learner import Learner

Arrays: TypeAlias = dict[str, NDArray[Any]]


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class LegacyRandom(_Record):
    """Numpy's global generator, but for its key: stable-baselines3 shuffles minibatches with it."""

    pos: int
    has_gauss: int
    gauss: float


class LearnerFacts(_Record):
    """What of a learner is no array."""

    steps: int
    updates: int
    normaliser_count: float
    legacy_random: LegacyRandom
    starts: list[dict[str, Any]]  # the state of each robot's stream
    courses: list[dict[str, Any]]


@dataclass(frozen=True, slots=True)
class Snapshot:
    """A learner's state."""

    arrays: Arrays
    facts: LearnerFacts


def take(learner: Learner) -> Snapshot:
    """Return the state of a learner that is between an update and the next rollout."""
    ppo, env, statistics = learner.ppo, learner.env, learner.statistics
    arrays: Arrays = {f"policy.{name}": value.numpy() for name, value in ppo.policy.state_dict().items()}
    for index, state in ppo.policy.optimizer.state_dict()["state"].items():
        arrays |= {f"optimiser.{index}.{name}": value.numpy() for name, value in state.items()}
    arrays |= {"normaliser.mean": statistics.mean, "normaliser.var": statistics.var}
    arrays |= {"learner.last_obs": _present(ppo._last_obs), "learner.starts": _present(ppo._last_episode_starts)}
    arrays |= {f"progress.{name}": array for name, array in _progress(learner).items()}
    arrays |= {"env.integration": env.batch.integration, "env.noise": env.noise}
    arrays |= {f"randomized.{name}": array for name, array in env.randomized.state().items()}
    if env.failed is not None:
        arrays |= {f"failed.{name}": array for name, array in env.failed.state().items()}
    legacy = _legacy_state()
    arrays |= {"random.torch": torch.get_rng_state().numpy(), "random.numpy": legacy["state"]["key"]}
    facts = LearnerFacts(
        steps=learner.steps,
        updates=ppo._n_updates,
        normaliser_count=float(statistics.count),
        legacy_random=LegacyRandom(
            pos=legacy["state"]["pos"], has_gauss=legacy["has_gauss"], gauss=float(legacy["gauss"])
        ),
        starts=[dict(rng.bit_generator.state) for rng in env.starts],
        courses=[dict(rng.bit_generator.state) for rng in env.courses],
    )
    return Snapshot({name: np.ascontiguousarray(array) for name, array in arrays.items()}, facts)


def restore(learner: Learner, snapshot: Snapshot) -> None:
    """Put a fresh learner of the same recipe into a state.

    Raises:
        KeyError, RuntimeError, ValueError: the state is of another kind of learner.
    """
    _restore_ppo(learner, snapshot.arrays, snapshot.facts)
    _restore_env(learner, snapshot.arrays, snapshot.facts)
    _restore_random(snapshot.arrays, snapshot.facts.legacy_random)


def _restore_ppo(learner: Learner, arrays: Arrays, facts: LearnerFacts) -> None:
    ppo, statistics = learner.ppo, learner.statistics
    parts = _section(arrays, "policy")
    ppo.policy.load_state_dict({name: torch.from_numpy(array) for name, array in parts.items()})
    optimiser = ppo.policy.optimizer.state_dict()
    moments: dict[int, dict[str, torch.Tensor]] = {}
    for name, array in _section(arrays, "optimiser").items():
        index, _, kind = name.partition(".")
        moments.setdefault(int(index), {})[kind] = torch.from_numpy(array)
    ppo.policy.optimizer.load_state_dict(optimiser | {"state": moments})
    statistics.mean, statistics.var = arrays["normaliser.mean"], arrays["normaliser.var"]
    statistics.count = facts.normaliser_count
    ppo._last_obs, ppo._last_episode_starts = arrays["learner.last_obs"], arrays["learner.starts"]
    ppo.num_timesteps, ppo._n_updates = facts.steps, facts.updates


def _restore_env(learner: Learner, arrays: Arrays, facts: LearnerFacts) -> None:
    env = learner.env
    env.batch.integration[:] = arrays["env.integration"]
    env.noise[:] = arrays["env.noise"]
    env.randomized.restore(_section(arrays, "randomized"))
    if env.failed is not None:
        env.failed.restore(_section(arrays, "failed"))
    for name, array in _progress(learner).items():
        array[:] = arrays[f"progress.{name}"]
    for streams, states in ((env.starts, facts.starts), (env.courses, facts.courses)):
        for rng, state in zip(streams, states, strict=True):
            rng.bit_generator.state = state


def _restore_random(arrays: Arrays, legacy: LegacyRandom) -> None:
    torch.set_rng_state(torch.from_numpy(arrays["random.torch"]))
    # Stable-baselines3 shuffles minibatches with numpy's global generator.
    np.random.set_state(  # noqa: NPY002
        ("MT19937", arrays["random.numpy"], legacy.pos, legacy.has_gauss, legacy.gauss)
    )


def _progress(learner: Learner) -> Arrays:
    """Return all that the courses keep, whatever it is called: what is not an array follows from the recipe."""
    return {name: value for name, value in vars(learner.env.progress).items() if isinstance(value, np.ndarray)}


def _legacy_state() -> dict[str, Any]:
    state = np.random.get_state(legacy=False)  # noqa: NPY002 - the generator that stable-baselines3 uses
    assert isinstance(state, dict)
    return state


def _section(arrays: Arrays, name: str) -> Arrays:
    return {key.removeprefix(f"{name}."): array for key, array in arrays.items() if key.startswith(f"{name}.")}


def _present(value: Any) -> NDArray[Any]:
    assert isinstance(value, np.ndarray)
    return value
