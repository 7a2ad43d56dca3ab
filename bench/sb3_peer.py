"""The peer of time_to_target: stable-baselines3's PPO with rl-baselines3-zoo's tuned settings on the same task."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, TypeAlias

from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import SubprocVecEnv, VecNormalize
from torch import nn

from bench.attempt import Attempt, Look, Stopwatch
from waypointctl.evaluation.evaluate import evaluate
from waypointctl.evaluation.suite import Suite
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.task.config import TaskConfig
from waypointctl.task.env import WaypointEnv
from waypointctl.training.recipe import Recipe
from waypointctl.training.sb3_import import import_sb3

Tell: TypeAlias = Callable[[Look], None]

PROCESSES: Final = 16  # the zoo's n_envs

# AntBulletEnv-v0, the tuned one of the zoo's two ants, as of 2025:
# https://github.com/DLR-RM/rl-baselines3-zoo/blob/master/hyperparams/ppo.yml
# "normalize: true" is VecNormalize of observations and rewards with the same gamma.
ZOO: Final[dict[str, Any]] = {
    "n_steps": 512,
    "batch_size": 128,
    "n_epochs": 20,
    "gamma": 0.99,
    "gae_lambda": 0.9,
    "clip_range": 0.4,
    "ent_coef": 0.0,
    "vf_coef": 0.5,
    "max_grad_norm": 0.5,
    "learning_rate": 3e-5,
    "use_sde": True,
    "sde_sample_freq": 4,
    "policy_kwargs": {
        "log_std_init": -1.0,
        "ortho_init": False,
        "activation_fn": nn.ReLU,
        "net_arch": {"pi": [256, 256], "vf": [256, 256]},
    },
}


class PeerEnv(WaypointEnv):
    """`waypointctl/Waypoint-v0`, whose pay can change between episodes."""

    def enter(self, task: TaskConfig) -> None:
        """Pay as another phase does, from the next episode on."""
        self._config = task


class PeerWatcher(BaseCallback):
    """Tests the peer every so many steps, changes its pay with the phase, and ends it at the target or the limit."""

    def __init__(
        self,
        recipe: Recipe,
        target: float,
        every: int,
        limit_s: float,
        stopwatch: Stopwatch,
        test: Callable[[], float],
        tell: Tell,
    ) -> None:
        """Watch over a training with the recipe's phases; `test` returns the success rate of what is learnt so far."""
        super().__init__()
        self.recipe, self.every, self.limit_s, self.stopwatch = recipe, every, limit_s, stopwatch
        self.test, self.tell, self.target = test, tell, target
        self.looks: list[Look] = []
        self.phase, self.over = 0, False

    def _on_rollout_start(self) -> None:
        phase, _ = self.recipe.phase_at(self.num_timesteps)
        if phase != self.phase:
            self.phase = phase
            self.training_env.env_method("enter", self.recipe.task(phase))
        late = self.stopwatch.seconds >= self.limit_s
        if late or self.num_timesteps >= (len(self.looks) + 1) * self.every:
            spent_s = self.stopwatch.seconds
            with self.stopwatch.pause():
                self.looks.append(Look(self.num_timesteps, spent_s, self.test()))
                self.tell(self.looks[-1])
            self.over = late or self.looks[-1].success_rate >= self.target

    def _on_step(self) -> bool:
        return not self.over


def train_peer(recipe: Recipe, suite: Suite, every: int, limit_s: float, processes: int, tell: Tell) -> Attempt:
    """Train with stable-baselines3's PPO and the zoo's settings, until the target is met or the time is over."""
    selection, stopwatch = recipe.selection, Stopwatch()
    assert selection is not None
    assert selection.stop_at is not None
    task = recipe.task(0)
    env = VecNormalize(SubprocVecEnv([lambda: PeerEnv(task)] * processes), gamma=ZOO["gamma"])
    env.seed(recipe.seed)

    def success_rate() -> float:
        with TemporaryDirectory() as folder:
            found = evaluate(_bundle(model, env, recipe, Path(folder)), suite, selection.trials, selection.seed)
        return sum(case.successes for case in found.cases) / sum(case.trials for case in found.cases)

    try:
        model = PPO("MlpPolicy", env, seed=recipe.seed, device="cpu", **ZOO)
        watcher = PeerWatcher(recipe, selection.stop_at, every, limit_s, stopwatch, success_rate, tell)
        model.learn(10**12, watcher)
    finally:
        env.close()
    return Attempt(tuple(watcher.looks), selection.stop_at)


def _bundle(model: PPO, env: VecNormalize, recipe: Recipe, folder: Path) -> LoadedPolicy:
    """Return what the peer has learnt as a policy, the way its users would bring it here."""
    archive, normaliser = folder / "model.zip", folder / "vecnormalize.pkl"
    model.save(archive)
    env.save(str(normaliser))
    place = folder / "policy"
    return import_sb3(
        archive, place, robot=recipe.robot, observation=recipe.observation, vecnormalize=normaliser
    ).policy
