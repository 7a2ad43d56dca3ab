"""Stable-baselines3's PPO as a learner."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import torch
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.vec_env import VecNormalize
from torch import nn

from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.training.algorithms.onnx_export import mlp_to_onnx
from waypointctl.training.algorithms.ppo import PpoRecipe
from waypointctl.training.algorithms.vec_env import BatchedVecEnv
from waypointctl.training.learner import Arrays, ExportedPolicy, LearnerState, Rollout
from waypointctl.training.recipe import Recipe

ACTIVATIONS: Final = {"elu": nn.ELU, "tanh": nn.Tanh, "relu": nn.ReLU}


class GlobalRandom(BaseModel):
    """Numpy's global generator, but for its key: stable-baselines3 shuffles minibatches with it."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    pos: int
    has_gauss: int
    gauss: float


class PpoFacts(BaseModel):
    """The part of the state that is not an array."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    steps: int
    updates: int
    normaliser_count: float
    global_random: GlobalRandom


class PpoLearner:
    """PPO with its network and optimiser, and the running normalisation of the observations.

    Attributes:
        ppo: stable-baselines3's.
        normaliser: of the observations, around the robots.
    """

    algorithm = "PPO (stable-baselines3)"

    def __init__(self, settings: PpoRecipe, recipe: Recipe, env: BatchedWaypointEnv) -> None:
        """Make the network; nothing is simulated yet."""
        self._recipe = recipe
        self._robots = BatchedVecEnv(env, settings.reward_scale)
        self._callback: BaseCallback | None = None
        self.normaliser = VecNormalize(self._robots, norm_reward=False, clip_obs=settings.clip_observation)
        self.ppo = PPO(
            "MlpPolicy",
            self.normaliser,
            n_steps=settings.rollout_steps,
            batch_size=settings.minibatch,
            n_epochs=settings.epochs,
            gamma=settings.gamma,
            gae_lambda=settings.gae_lambda,
            clip_range=settings.clip,
            vf_coef=settings.value,
            max_grad_norm=settings.max_gradient,
            learning_rate=lambda _: recipe.schedules_at(self.steps)["learning_rate"],
            policy_kwargs={
                "net_arch": list(recipe.network.hidden),
                "activation_fn": ACTIVATIONS[recipe.network.activation],
                "log_std_init": settings.initial_log_std,
            },
            seed=recipe.seed,
            device="cpu",
            verbose=0,
        )
        self.ppo.set_logger(Logger(None, []))

    @property
    def steps(self) -> int:
        """Control steps of all robots so far."""
        # PPO reads the first learning rate in its constructor.
        return int(self.ppo.num_timesteps) if hasattr(self, "ppo") else 0

    @property
    def statistics(self) -> RunningMeanStd:
        """Mean and variance (k,) of the observations so far."""
        statistics = self.normaliser.obs_rms
        assert isinstance(statistics, RunningMeanStd)
        return statistics

    def collect(self) -> Rollout:
        """Fill the rollout buffer."""
        callback = self._begin()
        self.ppo.collect_rollouts(self.normaliser, callback, self.ppo.rollout_buffer, self.ppo.n_steps)
        return self._robots.drain()

    def update(self) -> dict[str, float]:
        """Go through the rollout buffer, `epochs` times."""
        self.ppo.ent_coef = entropy = self._recipe.schedules_at(self.steps)["entropy"]
        self.ppo.train()
        recorded = self.ppo.logger.name_to_value
        metrics = {name.removeprefix("train/"): float(value) for name, value in recorded.items()}
        self.ppo.logger.dump(self.steps)  # into nothing: it forgets them
        return metrics | {"entropy": entropy}

    def is_finite(self) -> bool:
        """Return whether the network and the normaliser have finite numbers alone."""
        return all(np.isfinite(array).all() for array in self._weights().values())

    def save(self) -> LearnerState:
        """Return the state: network, optimiser, normaliser, last observations and the global generators."""
        self._begin()
        ppo, statistics = self.ppo, self.statistics
        arrays: Arrays = {f"policy.{name}": value.numpy() for name, value in ppo.policy.state_dict().items()}
        for index, state in ppo.policy.optimizer.state_dict()["state"].items():
            arrays |= {f"optimiser.{index}.{name}": value.numpy() for name, value in state.items()}
        arrays |= {"normaliser.mean": statistics.mean, "normaliser.var": statistics.var}
        arrays |= {"observations": _present(ppo._last_obs), "episode_starts": _present(ppo._last_episode_starts)}
        random: Any = np.random.get_state(legacy=False)  # noqa: NPY002 - stable-baselines3 shuffles with it
        arrays |= {"random.torch": torch.get_rng_state().numpy(), "random.numpy": random["state"]["key"]}
        facts = PpoFacts(
            steps=self.steps,
            updates=ppo._n_updates,
            normaliser_count=float(statistics.count),
            global_random=GlobalRandom(
                pos=random["state"]["pos"], has_gauss=random["has_gauss"], gauss=float(random["gauss"])
            ),
        )
        return LearnerState(arrays, facts.model_dump())

    def load(self, state: LearnerState) -> None:
        """Continue from a state."""
        arrays, facts = state.arrays, PpoFacts.model_validate(state.facts)
        ppo, statistics = self.ppo, self.statistics
        parts = _section(arrays, "policy")
        ppo.policy.load_state_dict({name: torch.from_numpy(array) for name, array in parts.items()})
        moments: dict[int, dict[str, torch.Tensor]] = {}
        for name, array in _section(arrays, "optimiser").items():
            index, _, kind = name.partition(".")
            moments.setdefault(int(index), {})[kind] = torch.from_numpy(array)
        ppo.policy.optimizer.load_state_dict(ppo.policy.optimizer.state_dict() | {"state": moments})
        statistics.mean, statistics.var = arrays["normaliser.mean"], arrays["normaliser.var"]
        statistics.count = facts.normaliser_count
        ppo._last_obs, ppo._last_episode_starts = arrays["observations"], arrays["episode_starts"]
        ppo.num_timesteps, ppo._n_updates = facts.steps, facts.updates
        torch.set_rng_state(torch.from_numpy(arrays["random.torch"]))
        random = facts.global_random
        legacy = ("MT19937", arrays["random.numpy"], random.pos, random.has_gauss, random.gauss)
        np.random.set_state(legacy)  # noqa: NPY002 - as above

    def export(self) -> ExportedPolicy:
        """Return the mean of the actions as ONNX, and the whole network's weights."""
        policy, statistics = self.ppo.policy, self.statistics
        modules = [*policy.mlp_extractor.policy_net, policy.action_net]
        linear = [module for module in modules if isinstance(module, nn.Linear)]
        onnx = mlp_to_onnx(
            [(layer.weight.detach().numpy(), layer.bias.detach().numpy()) for layer in linear],
            self._recipe.network.activation,
            statistics.mean,
            statistics.var,
            clip=self.normaliser.clip_obs,
            epsilon=self.normaliser.epsilon,
        )
        return ExportedPolicy(onnx, self._weights())

    def warm_start(self, weights: dict[str, NDArray[np.generic]], *, other_inputs: bool) -> None:
        """Begin with the network, value function and normaliser of another policy.

        With inputs of another meaning, the normaliser's statistics weigh as much as one rollout: with the weight of
        the whole training behind them these inputs would stay out of its range for as long again.
        """
        own = self._weights()
        if {name: array.shape for name, array in own.items()} != {name: each.shape for name, each in weights.items()}:
            raise ValueError("its weights have other names or shapes than PPO has here")
        network = {name: torch.from_numpy(np.array(weights[name])) for name in self.ppo.policy.state_dict()}
        self.ppo.policy.load_state_dict(network)
        statistics, count = self.statistics, float(weights["normaliser.count"])
        statistics.mean = np.array(weights["normaliser.mean"], np.float64)
        statistics.var = np.array(weights["normaliser.var"], np.float64)
        statistics.count = min(count, float(self._recipe.algorithm.iteration_steps)) if other_inputs else count

    def _begin(self) -> BaseCallback:
        """Let stable-baselines3 begin its first episodes, unless a state has been loaded."""
        if self._callback is None:
            _, self._callback = self.ppo._setup_learn(0, None, reset_num_timesteps=False)
        return self._callback

    def _weights(self) -> dict[str, NDArray[np.generic]]:
        tensors = {name: tensor.detach().numpy() for name, tensor in self.ppo.policy.state_dict().items()}
        statistics = self.statistics
        return tensors | {
            "normaliser.mean": statistics.mean,
            "normaliser.var": statistics.var,
            "normaliser.count": np.array(statistics.count),
        }


def _section(arrays: Arrays, name: str) -> Arrays:
    return {key.removeprefix(f"{name}."): array for key, array in arrays.items() if key.startswith(f"{name}.")}


def _present(value: object) -> NDArray[Any]:
    assert isinstance(value, np.ndarray)
    return value
