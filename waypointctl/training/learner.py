"""The learner: stable-baselines3's PPO on the batched env, as a recipe says."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.vec_env import VecNormalize
from torch import nn

from waypointctl.policy.manifest import StartRecord
from waypointctl.sim.batch import default_threads
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.training.recipe import Recipe
from waypointctl.training.status import Threads
from waypointctl.training.vec_env import BatchedVecEnv

# Layers of 128 gain little from more than one thread, and lose much beside other work (bench/threads.py).
TORCH_THREADS: Final = 1
ACTIVATIONS: Final = {"elu": nn.ELU, "tanh": nn.Tanh, "relu": nn.ReLU}


class Learner:
    """A policy being trained: the robots, the normaliser and PPO.

    Attributes:
        recipe: what it follows.
        env: the robots.
        robots: `env` as stable-baselines3 takes it.
        normaliser: of the observations, around `robots`.
        ppo: the algorithm, with policy and optimiser.
        start: the policy that it began with the weights of, if it did.
        threads: that it is trained with.
    """

    def __init__(self, recipe: Recipe, threads: int) -> None:
        """Begin a training.

        Args:
            recipe: what to follow.
            threads: of physics and of torch; 0 is the default: `default_threads()` of physics, TORCH_THREADS of torch.
        """
        self.threads = Threads(threads or default_threads(), threads or TORCH_THREADS, asked=threads > 0)
        torch.set_num_threads(self.threads.torch)
        self.recipe = recipe
        self.start: StartRecord | None = None
        ppo, net = recipe.ppo, recipe.network
        self.env = BatchedWaypointEnv(recipe.task(0), ppo.robots, recipe.seed, threads=self.threads.physics)
        self.robots = BatchedVecEnv(self.env, ppo.reward_scale)
        self.normaliser = VecNormalize(self.robots, norm_reward=False, clip_obs=ppo.clip_observation)
        self.ppo = PPO(
            "MlpPolicy",
            self.normaliser,
            n_steps=ppo.rollout_steps,
            batch_size=ppo.minibatch,
            n_epochs=ppo.epochs,
            gamma=ppo.gamma,
            gae_lambda=ppo.gae_lambda,
            clip_range=ppo.clip,
            ent_coef=ppo.entropy,
            vf_coef=ppo.value,
            max_grad_norm=ppo.max_gradient,
            learning_rate=lambda _: recipe.learning_rate_at(self.steps),
            policy_kwargs={
                "net_arch": list(net.hidden),
                "activation_fn": ACTIVATIONS[net.activation],
                "log_std_init": net.initial_log_std,
            },
            seed=recipe.seed,
            device="cpu",
            verbose=0,
        )

    def use_torch_threads(self, number: int) -> None:
        """Go on with as many threads of the network as the run began with, unless another number was asked for."""
        self.threads = replace(self.threads, began=number, torch=self.threads.torch if self.threads.asked else number)
        torch.set_num_threads(self.threads.torch)

    @property
    def steps(self) -> int:
        """Control steps of all robots so far."""
        # PPO asks for the first learning rate while it is being made.
        return int(self.ppo.num_timesteps) if hasattr(self, "ppo") else 0

    @property
    def statistics(self) -> RunningMeanStd:
        """Mean and variance (k,) of the observations so far."""
        statistics = self.normaliser.obs_rms
        assert isinstance(statistics, RunningMeanStd)
        return statistics

    def enter_phase(self) -> int:
        """Pay as the phase of the present step says; return its number."""
        phase, _ = self.recipe.phase_at(self.steps)
        self.env.config = self.recipe.task(phase)
        return phase

    def weigh_entropy(self) -> float:
        """Weigh the entropy bonus of the next update as the present step says; return the weight."""
        self.ppo.ent_coef = self.recipe.entropy_at(self.steps)
        return self.ppo.ent_coef

    def learn(self, callback: BaseCallback) -> None:
        """Train from the present step to the recipe's last, or until the callback ends it."""
        # Not reset, even at step 0: a checkpoint of that step has begun its episodes, and a new learner begins them.
        self.ppo.learn(self.recipe.total_steps - self.steps, callback, reset_num_timesteps=False)
