"""What of a recipe says how it is learnt: network, PPO, phases."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, Strict, model_validator

from waypointctl.mission.file_model import FileModel
from waypointctl.task.reward import RewardWeights
from waypointctl.training.recipe_fields import Count, Factor, Few, Fraction, Rate


class NetworkRecipe(FileModel):
    """The policy's network; the value function has one of the same shape."""

    hidden: Annotated[tuple[Few, ...], Field(min_length=1, max_length=12)] = (128, 128, 128)
    activation: Literal["elu", "tanh", "relu"] = "elu"
    initial_log_std: Annotated[float, Strict(), Field(ge=-5, le=2)] = -0.7


class PpoRecipe(FileModel):
    """Proximal policy optimisation, in stable-baselines3's terms."""

    robots: Few = Field(256, description="side by side")
    rollout_steps: Few = Field(48, description="of each robot, between updates")
    minibatch: Annotated[int, Strict(), Field(ge=2)] = Field(2048, description="samples of each step of the optimiser")
    epochs: Few = Field(4, description="how often an update goes through the samples")
    gamma: Fraction = 0.99
    gae_lambda: Fraction = 0.95
    clip: Rate = 0.2
    entropy: Fraction = Field(0.0, description="weight of the entropy bonus, in phases that have none of their own")
    value: Annotated[float, Strict(), Field(gt=0, le=10)] = Field(0.5, description="weight of the value loss")
    max_gradient: Factor = Field(0.5, description="norm that the gradient is clipped to")
    reward_scale: Factor = Field(0.1, description="of all rewards, for the value function")
    clip_observation: Factor = Field(10.0, description="of normalised observations")

    @model_validator(mode="after")
    def _whole_minibatches(self) -> PpoRecipe:
        samples = self.robots * self.rollout_steps
        if samples % self.minibatch:
            raise ValueError(f"robots x rollout_steps = {samples} is no multiple of minibatch = {self.minibatch}")
        return self


class PhaseRecipe(FileModel):
    """A stretch of the training with its own reward weights and learning rate."""

    steps: Count = Field(description="control steps of all robots together")
    learning_rate: tuple[Rate, Rate] = Field((6e-4, 6e-5), description="at the phase's beginning and end")
    entropy: tuple[Fraction, Fraction] | None = Field(
        None, description="weight of the entropy bonus at the phase's beginning and end; ppo.entropy unless told"
    )
    reward: RewardWeights = RewardWeights()
