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

from waypointctl.policy.write import mlp_to_onnx
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.training.algorithms.vec_env import BatchedVecEnv
from waypointctl.training.learner import ExportedPolicy, LearnerTask, Rollout, SavedState, prefixed, section

ACTIVATIONS: Final = {"elu": nn.ELU, "tanh": nn.Tanh, "relu": nn.ReLU}


class PpoFacts(BaseModel):
    """The part of the state that is not an array.

    Attributes:
        steps: control steps of all robots so far.
        updates: stable-baselines3's count.
        normaliser_count: of the observations that its statistics are of.
        numpy_pos, numpy_has_gauss, numpy_gauss: of numpy's global generator: stable-baselines3 shuffles with it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    steps: int
    updates: int
    normaliser_count: float
    numpy_pos: int
    numpy_has_gauss: int
    numpy_gauss: float


class PpoLearner:
    """PPO with its network and optimiser, and the running normalisation of the observations.

    Attributes:
        ppo: stable-baselines3's.
        normaliser: of the observations, around the robots.
    """

    algorithm = "PPO (stable-baselines3)"

    def __init__(
        self,
        task: LearnerTask,
        env: BatchedWaypointEnv,
        *,
        reward_scale: float,
        clip_observation: float,
        initial_log_std: float,
        **settings: Any,
    ) -> None:
        """Make the network; nothing is simulated yet.

        Args:
            task: what the recipe says beside PPO's own block.
            env: the robots.
            reward_scale: multiplies all rewards.
            clip_observation: bound of the normalised observations.
            initial_log_std: logarithm of the standard deviation of the first actions.
            settings: stable-baselines3's, by its names.
        """
        self._task = task
        self._robots = BatchedVecEnv(env, reward_scale)
        self._callback: BaseCallback | None = None
        self.normaliser = VecNormalize(self._robots, norm_reward=False, clip_obs=clip_observation)
        self.ppo = PPO(
            "MlpPolicy",
            self.normaliser,
            learning_rate=lambda _: task.schedules_at(self.steps)["learning_rate"],
            policy_kwargs={
                "net_arch": list(task.network.hidden),
                "activation_fn": ACTIVATIONS[task.network.activation],
                "log_std_init": initial_log_std,
            },
            seed=task.seed,
            device="cpu",
            verbose=0,
            **settings,
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
        self.ppo.ent_coef = entropy = self._task.schedules_at(self.steps)["entropy"]
        self.ppo.train()
        recorded = self.ppo.logger.name_to_value
        metrics = {name.removeprefix("train/"): float(value) for name, value in recorded.items()}
        self.ppo.logger.dump(self.steps)  # into nothing: it forgets them
        return metrics | {"entropy": entropy}

    def is_finite(self) -> bool:
        """Return whether the network and the normaliser have finite numbers alone."""
        return all(np.isfinite(array).all() for array in self._weights().values())

    def save(self) -> SavedState:
        """Return the state: network, optimiser, normaliser, last observations and the global generators."""
        self._begin()
        ppo, statistics = self.ppo, self.statistics
        arrays = prefixed("policy", {name: value.numpy() for name, value in ppo.policy.state_dict().items()})
        for index, state in ppo.policy.optimizer.state_dict()["state"].items():
            arrays |= prefixed(f"optimiser.{index}", {name: value.numpy() for name, value in state.items()})
        arrays |= {"normaliser.mean": statistics.mean, "normaliser.var": statistics.var}
        arrays |= {"observations": _present(ppo._last_obs), "episode_starts": _present(ppo._last_episode_starts)}
        random: Any = np.random.get_state(legacy=False)  # noqa: NPY002 - stable-baselines3 shuffles with it
        arrays |= {"random.torch": torch.get_rng_state().numpy(), "random.numpy": random["state"]["key"]}
        facts = PpoFacts(
            steps=self.steps,
            updates=ppo._n_updates,
            normaliser_count=float(statistics.count),
            numpy_pos=random["state"]["pos"],
            numpy_has_gauss=random["has_gauss"],
            numpy_gauss=float(random["gauss"]),
        )
        return SavedState(arrays, facts.model_dump())

    def load(self, state: SavedState) -> None:
        """Continue from a state."""
        arrays, facts = state.arrays, PpoFacts.model_validate(state.facts)
        ppo, statistics = self.ppo, self.statistics
        parts = section(arrays, "policy")
        ppo.policy.load_state_dict({name: torch.from_numpy(array) for name, array in parts.items()})
        moments: dict[int, dict[str, torch.Tensor]] = {}
        for name, array in section(arrays, "optimiser").items():
            index, _, kind = name.partition(".")
            moments.setdefault(int(index), {})[kind] = torch.from_numpy(array)
        ppo.policy.optimizer.load_state_dict(ppo.policy.optimizer.state_dict() | {"state": moments})
        statistics.mean, statistics.var = arrays["normaliser.mean"], arrays["normaliser.var"]
        statistics.count = facts.normaliser_count
        ppo._last_obs, ppo._last_episode_starts = arrays["observations"], arrays["episode_starts"]
        ppo.num_timesteps, ppo._n_updates = facts.steps, facts.updates
        torch.set_rng_state(torch.from_numpy(arrays["random.torch"]))
        legacy = ("MT19937", arrays["random.numpy"], facts.numpy_pos, facts.numpy_has_gauss, facts.numpy_gauss)
        np.random.set_state(legacy)  # noqa: NPY002 - as above

    def export(self) -> ExportedPolicy:
        """Return the mean of the actions as ONNX, and the whole network's weights."""
        policy, statistics = self.ppo.policy, self.statistics
        modules = [*policy.mlp_extractor.policy_net, policy.action_net]
        linear = [module for module in modules if isinstance(module, nn.Linear)]
        onnx = mlp_to_onnx(
            [(layer.weight.detach().numpy(), layer.bias.detach().numpy()) for layer in linear],
            self._task.network.activation,
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
        statistics.count = min(count, float(self.ppo.n_steps * self.ppo.n_envs)) if other_inputs else count

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


def _present(value: object) -> NDArray[Any]:
    assert isinstance(value, np.ndarray)
    return value
