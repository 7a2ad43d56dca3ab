"""The training loop with an algorithm that is neither PPO nor of stable-baselines3."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.training.tiny import tiny_recipe, trained, weights_of
from waypointctl.policy.write import mlp_to_onnx
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.training.learner import AlgorithmRecipe, ExportedPolicy, LearnerTask, Rollout, SavedState
from waypointctl.training.progress import read_progress

STEPS = 4  # control steps between two updates


class RandomSearchRecipe(AlgorithmRecipe):
    """Random steps of a linear policy."""

    @property
    def iteration_steps(self) -> int:
        return self.robots * STEPS

    def make_learner(self, task: LearnerTask, env: BatchedWaypointEnv) -> RandomSearch:
        return RandomSearch(task.seed, env)


class RandomSearch:
    algorithm = "random search"

    def __init__(self, seed: int, env: BatchedWaypointEnv) -> None:
        self._env, self._rng = env, np.random.default_rng(seed)
        self._seen: NDArray[np.float64] | None = None
        self.weight = np.zeros((env.robot.num_actions, env.layout.size))
        self.steps = 0

    def _observation(self) -> NDArray[np.float64]:
        return self._env.reset() if self._seen is None else self._seen

    def collect(self) -> Rollout:
        rollout, self._seen = Rollout(), self._observation()
        for _ in range(STEPS):
            step = self._env.step(self._seen @ self.weight.T)
            self._seen = step.observation
            rollout.add(step)
        self.steps += rollout.steps
        return rollout

    def update(self) -> dict[str, float]:
        self.weight += self._rng.normal(scale=0.01, size=self.weight.shape)
        return {"norm": float(np.linalg.norm(self.weight))}

    def is_finite(self) -> bool:
        return bool(np.isfinite(self.weight).all())

    def save(self) -> SavedState:
        self._seen = self._observation()
        facts = {"steps": self.steps, "random": dict(self._rng.bit_generator.state)}
        return SavedState({"weight": self.weight, "seen": self._seen}, facts)

    def load(self, state: SavedState) -> None:
        self.weight, self._seen = state.arrays["weight"], state.arrays["seen"]
        self.steps, self._rng.bit_generator.state = state.facts["steps"], state.facts["random"]

    def export(self) -> ExportedPolicy:
        outputs, inputs = self.weight.shape
        layers = [(np.eye(inputs)[:16], np.zeros(16)), (np.eye(16), np.zeros(16))]
        layers.append((self.weight[:, :16], np.zeros(outputs)))
        onnx = mlp_to_onnx(layers, "relu", np.zeros(inputs), np.ones(inputs), clip=10, epsilon=1e-8)
        return ExportedPolicy(onnx, {"weight": self.weight})

    def warm_start(self, weights: dict[str, NDArray[np.generic]], *, other_inputs: bool) -> None:
        raise ValueError("random search begins with zeros")


def test_another_algorithm_trains_resumes_exactly_and_becomes_a_policy(tmp_path: Path) -> None:
    recipe_file = tiny_recipe(tmp_path)
    recipe = recipe_file.recipe.scaled_to(256).model_copy(update={"algorithm": RandomSearchRecipe(robots=8)})
    recipe_file = replace(recipe_file, recipe=recipe)
    result = trained(recipe_file, tmp_path / "whole")
    assert result.policy.manifest.training.algorithm == "random search"
    assert result.steps == 256
    trained(recipe_file, tmp_path / "stopped", rollouts=3)
    trained(recipe_file, tmp_path / "stopped", resume=True)
    assert weights_of(tmp_path / "stopped") == weights_of(tmp_path / "whole")
    assert [row.schedules for row in read_progress(tmp_path / "whole")] == [{}] * 8
