"""Proximal policy optimisation (Schulman et al. 2017, arXiv:1707.06347), by stable-baselines3."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, Strict, model_validator

from waypointctl.training.learner import (
    AlgorithmRecipe,
    Factor,
    Few,
    Fraction,
    Learner,
    LearnerTask,
    Rate,
    RateSchedule,
    WeightSchedule,
)

if TYPE_CHECKING:
    from waypointctl.task.batched import BatchedWaypointEnv


class PpoRecipe(AlgorithmRecipe):
    """Proximal policy optimisation, in stable-baselines3's terms."""

    name: Literal["ppo"]
    rollout_steps: Few = Field(48, description="control steps of each robot between updates")
    minibatch: Annotated[int, Strict(), Field(ge=2)] = Field(2048, description="samples of each step of the optimiser")
    epochs: Few = Field(4, description="passes of an update through the samples")
    gamma: Fraction = 0.99
    gae_lambda: Fraction = 0.95
    clip: Rate = 0.2
    learning_rate: RateSchedule = Field(
        (6e-4, 6e-5),
        description="at the beginning and end of each phase that has none of its own; a number is constant",
    )
    entropy: WeightSchedule = Field((0.0, 0.0), description="weight of the entropy bonus, likewise")
    value: Annotated[float, Strict(), Field(gt=0, le=10)] = Field(0.5, description="weight of the value loss")
    max_gradient: Factor = Field(0.5, description="norm that the gradient is clipped to")
    reward_scale: Factor = Field(0.1, description="of all rewards, for the value function")
    clip_observation: Factor = Field(10.0, description="bound of the normalised observations")
    initial_log_std: Annotated[float, Strict(), Field(ge=-5, le=2)] = Field(
        -0.7, description="logarithm of the standard deviation of the first actions"
    )

    @model_validator(mode="after")
    def _whole_minibatches(self) -> PpoRecipe:
        if self.iteration_steps % self.minibatch:
            product = f"robots x rollout_steps = {self.iteration_steps}"
            raise ValueError(f"{product} is not a multiple of minibatch = {self.minibatch}")
        return self

    @property
    def iteration_steps(self) -> int:
        """Control steps of all robots in one rollout."""
        return self.robots * self.rollout_steps

    def make_learner(self, task: LearnerTask, env: BatchedWaypointEnv) -> Learner:
        """Return stable-baselines3's PPO on the robots."""
        from waypointctl.training.algorithms.ppo_learner import PpoLearner  # torch, which a recipe is read without

        return PpoLearner(
            task,
            env,
            reward_scale=self.reward_scale,
            clip_observation=self.clip_observation,
            initial_log_std=self.initial_log_std,
            n_steps=self.rollout_steps,
            batch_size=self.minibatch,
            n_epochs=self.epochs,
            gamma=self.gamma,
            gae_lambda=self.gae_lambda,
            clip_range=self.clip,
            vf_coef=self.value,
            max_grad_norm=self.max_gradient,
        )
