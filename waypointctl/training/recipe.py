"""A training recipe: the file that defines how a policy is trained."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, PrivateAttr, Strict, ValidationError, ValidationInfo, field_validator, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from waypointctl.errors import InputError, RobotError
from waypointctl.mission.fields import Acceptance, RobotName, Start
from waypointctl.mission.file_model import FileModel
from waypointctl.mission.policy_name import from_folder, is_bare
from waypointctl.robots.load import kept_robot, load_robot, robot_folder
from waypointctl.task.config import DomainRandomization, FailureReplay, TaskConfig
from waypointctl.task.course import Course, Deadline
from waypointctl.task.observation import groups_of
from waypointctl.task.plugins import Plugin
from waypointctl.task.reward import RewardFunction
from waypointctl.training.algorithms import Algorithm
from waypointctl.training.algorithms.ppo import PpoRecipe
from waypointctl.training.learner import Count, LearnerTask, NetworkRecipe, PhaseRecipe
from waypointctl.training.run_folder import PLUGIN_COPIES, keeps_copies
from waypointctl.training.selection import EvaluationRecipe, SelectionRecipe

LayoutName: TypeAlias = Literal["state", "state_noise", "state_goal", "egocentric"]
GroupName: TypeAlias = Annotated[str, Field(max_length=60)]
PluginFile: TypeAlias = Annotated[str, Field(min_length=1, max_length=1000)]


class Recipe(FileModel):
    """A training recipe."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=80)]
    description: Annotated[str, Field(max_length=4000)] = ""
    seed: Annotated[int, Strict(), Field(ge=0, lt=2**32)] = 0
    robot: RobotName = Field(
        "ant", description="a robot that comes with waypointctl, or a folder (./NAME), relative to this file"
    )
    plugins: Annotated[tuple[PluginFile, ...], Field(max_length=20)] = Field(
        (), description="Python files with observation groups and reward terms of your own, relative to this one"
    )
    observation: LayoutName | Annotated[tuple[GroupName, ...], Field(min_length=1, max_length=100)] = Field(
        "egocentric", description="a layout, or a list of observation groups"
    )
    course: Course = Field(Course(), description="where the waypoints of an episode come from")
    failure_replay: FailureReplay = Field(FailureReplay(), description="draw recently failed courses again")
    acceptance: Acceptance = Acceptance()
    deadline: Deadline = Deadline()
    start: Start = Start()
    domain_randomization: DomainRandomization = Field(
        DomainRandomization(), description="values drawn for each robot and episode in place of the model's"
    )
    network: NetworkRecipe = NetworkRecipe()
    algorithm: Algorithm = PpoRecipe(name="ppo")
    phases: Annotated[tuple[PhaseRecipe, ...], Field(min_length=1)]
    warm_start: Annotated[str, Field(min_length=1, max_length=1000)] | None = Field(
        None,
        description="policy whose weights the training begins with: its folder, relative to this file, or its name",
    )
    checkpoint_steps: Count = Field(1_000_000, description="control steps between checkpoints")
    evaluation: EvaluationRecipe = EvaluationRecipe()
    selection: SelectionRecipe | None = Field(
        None, description="how the policy is selected among the checkpoints; default: the last checkpoint"
    )

    _folder: Path = PrivateAttr(Path())

    @property
    def robot_path(self) -> str:
        """The robot's name, or the path of its folder, relative to the working directory."""
        kept = None if is_bare(self.robot) or not keeps_copies(self._folder) else kept_robot(self._folder)
        return from_folder(self.robot, self._folder) if kept is None else str(kept)

    @property
    def plugin_paths(self) -> tuple[Path, ...]:
        """The paths of the plugins' files, relative to the working directory."""
        paths = [(self._folder / name, self._folder / PLUGIN_COPIES / Path(name).name) for name in self.plugins]
        keeps = keeps_copies(self._folder)
        return tuple(copy if keeps and copy.is_file() else named for named, copy in paths)

    def read_from(self, folder: Path) -> Recipe:
        """Return the recipe as it is in a file of this folder.

        A run's folder and a policy's have copies of its robot and its plugins, which take precedence there.
        """
        recipe = self.model_copy()
        recipe._folder = folder
        return recipe

    @field_validator("robot")
    @classmethod
    def _exists(cls, robot: str) -> str:
        if is_bare(robot):
            try:
                robot_folder(robot)
            except RobotError as error:
                raise ValueError(f"{error.problem}; {error.hint}") from error
        return robot

    @field_validator("domain_randomization")
    @classmethod
    def _fits_the_robot(cls, randomization: DomainRandomization, info: ValidationInfo) -> DomainRandomization:
        if is_bare(info.data.get("robot", "")):  # a folder is read when the training begins
            try:
                randomization.latency_steps(load_robot(info.data["robot"]))
            except InputError as error:
                raise ValueError(error.problem) from error
        return randomization

    @model_validator(mode="after")
    def _names_what_there_is(self) -> Self:
        errors = [] if self.plugins else [_unknown(loc, text) for loc, text in unknown_names(self, ())]
        if errors:
            raise ValidationError.from_exception_data("recipe", errors)
        return self

    @field_validator("selection")
    @classmethod
    def _selected_and_reported_apart(
        cls, selection: SelectionRecipe | None, info: ValidationInfo
    ) -> SelectionRecipe | None:
        evaluation = info.data.get("evaluation")  # None: already reported as an error
        if selection is not None and evaluation is not None and selection.seed == evaluation.seed:
            text = (
                f"the seed {selection.seed} is also evaluation.seed: a policy must not be reported on the trials that "
                "selected it; use another seed for selection"
            )
            error = PydanticCustomError("recipe", "{text}", {"text": text})
            raise ValidationError.from_exception_data(
                "selection", [InitErrorDetails(type=error, loc=("seed",), input=selection.seed)]
            )
        return selection

    @property
    def total_steps(self) -> int:
        """Control steps of all robots in all phases."""
        return sum(phase.steps for phase in self.phases)

    @property
    def last_step(self) -> int:
        """Control step where training ends: `total_steps`, rounded up to whole rollouts."""
        return -(-self.total_steps // self.algorithm.iteration_steps) * self.algorithm.iteration_steps

    def phase_at(self, step: int) -> tuple[int, float]:
        """Return which phase a control step is in and how far through it that is, 0 to 1."""
        begun = 0
        for number, phase in enumerate(self.phases):
            if step < begun + phase.steps:
                return number, (step - begun) / phase.steps
            begun += phase.steps
        return len(self.phases) - 1, 1.0

    def schedules_at(self, step: int) -> dict[str, float]:
        """Return the values of the algorithm's schedules at a control step, by name."""
        number, progress = self.phase_at(step)
        own = self.phases[number]
        ends = {name: getattr(own, name) or default for name, default in self.algorithm.schedules.items()}
        return {name: first + (last - first) * progress for name, (first, last) in ends.items()}

    def learner_task(self) -> LearnerTask:
        """Return what a learner needs beside the block of its algorithm."""
        return LearnerTask(self.network, self.seed, self.schedules_at)

    def task(self, phase: int, plugins: tuple[Plugin, ...] = ()) -> TaskConfig:
        """Return the task as it is in a phase; plugins are the loaded ones."""
        return TaskConfig(
            robot=self.robot_path,
            observation=self.observation,
            reward=self.phases[phase].reward,
            course=self.course,
            failure_replay=self.failure_replay,
            acceptance=self.acceptance,
            deadline=self.deadline,
            start=self.start,
            domain_randomization=self.domain_randomization,
            plugins=plugins,
        )

    def stopping_at(self, rate: float) -> Recipe:
        """Return the recipe with its training ending when a success rate is reached.

        Raises:
            ValueError: the recipe selects nothing, and its evaluation has the seed of a selection by default.
        """
        selection = (self.selection or SelectionRecipe()).model_copy(update={"stop_at": rate})
        if selection.seed == self.evaluation.seed:
            raise ValueError(f"evaluation.seed is {selection.seed}, the default seed of a selection")
        return self.model_copy(update={"selection": selection})

    def scaled_to(self, steps: int) -> Recipe:
        """Return the recipe with its phases shortened or stretched to `steps` control steps in all.

        Every phase keeps at least one step.
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


def unknown_names(recipe: Recipe, plugins: tuple[Plugin, ...]) -> Iterator[tuple[tuple[str | int, ...], str]]:
    """Yield each place of a recipe that names a group or a reward term that is neither built in nor a plugin's."""
    try:
        groups_of(recipe.observation, plugins)
    except InputError as error:
        yield ("observation",), error.problem
    for number, phase in enumerate(recipe.phases):
        try:
            RewardFunction(phase.reward, plugins)
        except InputError as error:
            unknown = next((name for name in phase.reward.plugin_terms if repr(name) in error.problem), "")
            yield ("phases", number, "reward", *([unknown] if unknown else [])), error.problem


def _unknown(loc: tuple[str | int, ...], text: str) -> InitErrorDetails:
    kind = "extra_forbidden" if "reward" in loc else PydanticCustomError("recipe", "{text}", {"text": text})
    return InitErrorDetails(type=kind, loc=loc, input=None)
