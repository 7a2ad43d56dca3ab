"""A training recipe: everything that decides what a policy becomes, as a file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, Strict, model_validator

from waypointctl.mission.file_model import FileModel
from waypointctl.mission.quantity import Quantity
from waypointctl.task.acceptance import Acceptance
from waypointctl.task.config import TaskConfig
from waypointctl.task.course import Course, Deadline
from waypointctl.task.reward import RewardWeights
from waypointctl.task.start import Start

Count: TypeAlias = Annotated[int, Strict(), Field(gt=0, le=10**12)]
Few: TypeAlias = Annotated[int, Strict(), Field(gt=0, le=65_536)]  # of what takes memory
Fraction: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1)]
Rate: TypeAlias = Annotated[float, Strict(), Field(gt=0, le=1)]
# Bounds that no sound training comes near, and below which float32 does not overflow at the first step.
Cost: TypeAlias = Annotated[float, Strict(), Field(ge=0, le=1e6, allow_inf_nan=False)]
Factor: TypeAlias = Annotated[float, Strict(), Field(gt=0, le=1000, allow_inf_nan=False)]
Length: TypeAlias = Annotated[float, Quantity("m", gt=0, le=10_000)]
Place: TypeAlias = Annotated[float, Quantity("m", ge=-10_000, le=10_000)]
Duration: TypeAlias = Annotated[float, Quantity("s", gt=0, le=86_400)]


class CourseRecipe(FileModel):
    """Where the waypoints of an episode are drawn."""

    perimeter: Literal["square", "legs"] = Field(
        "square", description="square: each in a square; legs: each at a random distance and bearing from the last"
    )
    count: Few = Field(4, description="waypoints an episode, the paper's M")
    centre_m: tuple[Place, Place] = Field((10.0, 10.0), description="of the square")
    side_m: Length = Field(5.0, description="of the square")
    leg_m: tuple[Length, Length] = Field((1.0, 12.0), description="the shortest and the longest leg")

    @model_validator(mode="after")
    def _shortest_first(self) -> CourseRecipe:
        if self.leg_m[0] > self.leg_m[1]:
            raise ValueError(f"leg_m {list(self.leg_m)}: the shortest leg comes first")
        return self


class AcceptanceRecipe(FileModel):
    """When a waypoint counts as reached."""

    shape: Literal["box", "radius"] = "box"
    size_m: Length = Field(0.5, description="half the box's side, or the radius")


class DeadlineRecipe(FileModel):
    """How long an episode may take, as in the paper's Algorithm 1."""

    first_s: Duration = Field(10.0, description="to reach the first waypoint")
    further_s: Duration = Field(20.0, description="added for each waypoint reached")


class StartRecipe(FileModel):
    """How the robot stands when an episode begins."""

    position_m: tuple[Place, Place] = (0.0, 0.0)
    heading: Literal["random", "along_x"] = "along_x"
    joint_spread_rad: Annotated[float, Quantity("rad", ge=0, le=1)] = 0.1
    speed_spread: Annotated[float, Strict(), Field(ge=0, le=5)] = Field(0.1, description="in m/s and rad/s")


class RewardRecipe(FileModel):
    """What the policy is paid, term by term, in units of walking speed."""

    progress: Cost = Field(1.0, description="for each m/s of approach to the current waypoint")
    progress_cap_mps: Annotated[float, Strict(), Field(gt=0)] = Field(
        math.inf, description="a faster approach pays no more"
    )
    alive: Cost = Field(1.0, description="for each step not fallen")
    power: Cost = Field(2.0, description="against mean |action x scaled joint speed|")
    torque: Cost = Field(0.1, description="against mean action squared")
    joint_limits: Cost = Field(0.2, description="against each joint at its limit")
    tilt: Cost = Field(0.0, description="against 1 - up")
    wobble: Cost = Field(0.0, description="against roll rate squared plus pitch rate squared")
    fall: Cost = Field(0.0, description="against falling, once")


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
    entropy: Fraction = 0.0
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
    """A stretch of the training with its own pay and learning rate."""

    steps: Count = Field(description="control steps of all robots together")
    learning_rate: tuple[Rate, Rate] = Field((6e-4, 6e-5), description="at the phase's beginning and end")
    reward: RewardRecipe = RewardRecipe()


class EvaluationRecipe(FileModel):
    """The test that follows training."""

    trials: Few = Field(100, description="of each of the paper's cases")
    seed: Annotated[int, Strict(), Field(ge=0)] = 1


class Recipe(FileModel):
    """A training recipe."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=80)]
    description: Annotated[str, Field(max_length=4000)] = ""
    seed: Annotated[int, Strict(), Field(ge=0, lt=2**32)] = 0
    robot: Literal["ant"] = "ant"
    observation: Literal["state", "state_noise", "state_goal", "egocentric"] = "egocentric"
    course: CourseRecipe = CourseRecipe()
    acceptance: AcceptanceRecipe = AcceptanceRecipe()
    deadline: DeadlineRecipe = DeadlineRecipe()
    start: StartRecipe = StartRecipe()
    network: NetworkRecipe = NetworkRecipe()
    ppo: PpoRecipe = PpoRecipe()
    phases: Annotated[tuple[PhaseRecipe, ...], Field(min_length=1)]
    checkpoint_steps: Count = Field(1_000_000, description="control steps between checkpoints")
    evaluation: EvaluationRecipe = EvaluationRecipe()

    @property
    def total_steps(self) -> int:
        """Control steps of all robots in all phases."""
        return sum(phase.steps for phase in self.phases)

    def phase_at(self, step: int) -> tuple[int, float]:
        """Return which phase a control step is in and how far through it that is, 0 to 1."""
        begun = 0
        for number, phase in enumerate(self.phases):
            if step < begun + phase.steps:
                return number, (step - begun) / phase.steps
            begun += phase.steps
        return len(self.phases) - 1, 1.0

    def learning_rate_at(self, step: int) -> float:
        """Return the learning rate at a control step."""
        number, progress = self.phase_at(step)
        first, last = self.phases[number].learning_rate
        return first + (last - first) * progress

    def task(self, phase: int) -> TaskConfig:
        """Return the task as it is in a phase."""
        heading_rad = None if self.start.heading == "random" else 0.0
        return TaskConfig(
            robot=self.robot,
            observation=self.observation,
            reward=RewardWeights(**self.phases[phase].reward.model_dump()),
            course=Course(**self.course.model_dump()),
            acceptance=Acceptance(**self.acceptance.model_dump()),
            deadline=Deadline(**self.deadline.model_dump()),
            start=Start(
                position_m=self.start.position_m,
                heading_rad=heading_rad,
                joint_spread_rad=self.start.joint_spread_rad,
                speed_spread=self.start.speed_spread,
            ),
        )

    def scaled_to(self, steps: int) -> Recipe:
        """Return the recipe with its phases shortened or stretched to `steps` control steps in all.

        No phase vanishes: with fewer steps than phases there are as many steps as phases.
        """
        total, begun, ends = self.total_steps, 0, [0]
        for phase in self.phases:
            begun += phase.steps
            ends.append(max(ends[-1] + 1, (2 * begun * steps + total) // (2 * total)))
        return self.with_phase_steps([end - begin for begin, end in pairwise(ends)])

    def with_phase_steps(self, steps: Sequence[int]) -> Recipe:
        """Return the recipe with other lengths of its phases, in control steps, one for each."""
        lengths = zip(self.phases, steps, strict=True)
        return self.model_copy(
            update={"phases": tuple(phase.model_copy(update={"steps": length}) for phase, length in lengths)}
        )
