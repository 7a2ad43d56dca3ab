"""How fast training goes, where its time goes, and the same recipe on stable-baselines3's own worker processes.

Run: python bench/train_speed.py [--rounds 3] [--threads 0] [--recipe policies/ant-waypoint/train.yaml]

A round is some iterations (rollout and update) of `waypointctl train`, then one of the peer: PPO with the same
settings on SubprocVecEnv, 8 processes of waypointctl's WaypointEnv. The ratio is taken per round, so that a noisy
machine disturbs both. The peer collects fewer samples an iteration, in whole minibatches, and so has the same
update to pay for each sample.
"""

from __future__ import annotations

import argparse
import json
import statistics
from collections import defaultdict
from collections.abc import Callable, Mapping
from pathlib import Path
from time import perf_counter
from typing import Any

from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import SubprocVecEnv, VecNormalize

from waypointctl.task.config import TaskConfig
from waypointctl.task.env import WaypointEnv
from waypointctl.training.algorithms.ppo_learner import ACTIVATIONS, PpoLearner
from waypointctl.training.recipe import Recipe
from waypointctl.training.recipe_file import RecipeFile, load_recipe
from waypointctl.training.state import TrainingState

PROCESSES = 8
ITERATIONS = 2  # of ours a round
RECIPE = Path("policies/ant-waypoint/train.yaml")


class Stopwatch:
    """Adds up the time spent in methods, by a name for each."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self.seconds: defaultdict[str, float] = defaultdict(float)

    def watch(self, owner: object, method: str, name: str) -> None:
        """Time every call of a method of one object from here on."""
        call: Callable[..., Any] = getattr(owner, method)

        def timed(*args: Any, **kwargs: Any) -> Any:
            begin = perf_counter()
            try:
                return call(*args, **kwargs)
            finally:
                self.seconds[name] += perf_counter() - begin

        setattr(owner, method, timed)


def elapsed_s(work: Callable[[], object]) -> float:
    begin = perf_counter()
    work()
    return perf_counter() - begin


def watched(state: TrainingState, learner: PpoLearner) -> Stopwatch:
    stopwatch = Stopwatch()
    stopwatch.watch(state.env.batch, "step", "physics")
    stopwatch.watch(state.env, "step", "env")
    stopwatch.watch(learner.normaliser, "step_wait", "vec_env")
    stopwatch.watch(learner.ppo.policy, "forward", "inference")
    stopwatch.watch(learner.ppo, "train", "update")
    return stopwatch


def shares(seconds: Mapping[str, float], total_s: float) -> dict[str, float]:
    """Return what each part takes of the whole, none counted in another."""
    parts = {
        "physics": seconds["physics"],
        "observation_reward_reset": seconds["env"] - seconds["physics"],
        "vec_env_and_normaliser": seconds["vec_env"] - seconds["env"],
        "policy_inference": seconds["inference"],
        "update": seconds["update"],
    }
    parts["rollout_buffer_and_rest"] = total_s - sum(parts.values())
    return {name: round(part_s / total_s, 3) for name, part_s in parts.items()}


def peer(recipe: Recipe, task: TaskConfig) -> tuple[PPO, int]:
    """Return PPO on worker processes, and how many samples it takes an iteration."""
    ppo, net = recipe.algorithm, recipe.network
    env = VecNormalize(SubprocVecEnv([lambda: WaypointEnv(task)] * PROCESSES), norm_reward=False)
    model = PPO(
        "MlpPolicy",
        env,
        n_steps=ppo.minibatch // PROCESSES,
        batch_size=ppo.minibatch,
        n_epochs=ppo.epochs,
        learning_rate=1e-5,
        policy_kwargs={
            "net_arch": list(net.hidden),
            "activation_fn": ACTIVATIONS[net.activation],
            "log_std_init": ppo.initial_log_std,
        },
        seed=0,
        device="cpu",
    )
    return model, ppo.minibatch


def measure(recipe_file: RecipeFile, rounds: int, threads: int) -> dict[str, Any]:
    state, recipe = TrainingState(recipe_file, threads), recipe_file.recipe
    learner, samples = state.learner, recipe.algorithm.iteration_steps
    assert isinstance(learner, PpoLearner)
    model, peer_samples = peer(recipe, recipe.task(0))

    def ours() -> None:
        for _ in range(ITERATIONS):
            learner.collect()
            learner.update()

    def theirs() -> None:
        model.learn(peer_samples, reset_num_timesteps=False)

    for warm_up in (ours, theirs):
        warm_up()
    stopwatch = watched(state, learner)
    ours_s, theirs_s = [], []
    try:
        for _ in range(rounds):
            ours_s.append(elapsed_s(ours))
            theirs_s.append(elapsed_s(theirs))
    finally:
        model.get_env().close()  # type: ignore[union-attr]
    rates = [ITERATIONS * samples / time_s for time_s in ours_s]
    peer_rates = [peer_samples / time_s for time_s in theirs_s]
    return {
        "recipe": recipe.name,
        "samples_per_iteration": samples,
        "steps_per_s": round(statistics.median(rates)),
        "steps_per_s_peer": round(statistics.median(peer_rates)),
        "times_faster": round(statistics.median(a / b for a, b in zip(rates, peer_rates, strict=True)), 1),
        "share_of_time": shares(stopwatch.seconds, sum(ours_s)),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="Training's speed and where its time goes, against SubprocVecEnv.")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=0, help="of physics and network; 0 is one a core")
    parser.add_argument("--recipe", type=Path, default=RECIPE)
    options = parser.parse_args()
    print(json.dumps(measure(load_recipe(options.recipe), options.rounds, options.threads), indent=2))


if __name__ == "__main__":
    main()
