"""Which checkpoint becomes the policy: each is evaluated, the most successful is selected.

The results are in the run's selection.json. When the next evaluation is due follows from that alone, so that a training
that is killed and resumed evaluates the same checkpoints as an undisturbed one.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final

from pydantic import BaseModel, ConfigDict, Field, Strict, ValidationError

from waypointctl.errors import RecipeError
from waypointctl.input_file import NOT_THERE, RECORD_FILE, read_input
from waypointctl.mission.file_model import FileModel
from waypointctl.paths import write_whole
from waypointctl.policy.bundle import LoadedPolicy, load_policy_bytes
from waypointctl.policy.manifest import NETWORK, WEIGHTS, SelectionRecord
from waypointctl.policy.write import bundle_files
from waypointctl.training.learner import Count, Few, Rate

SELECTION: Final = "selection.json"


class EvaluationRecipe(FileModel):
    """The evaluation that follows training, on the paper's cases."""

    trials: Few = Field(100, description="of each of the paper's cases")
    seed: Annotated[int, Strict(), Field(ge=0)] = 1


class SelectionRecipe(FileModel):
    """Checkpoints are evaluated with deterministic actions; the most successful one becomes the policy."""

    suite: Annotated[str, Field(min_length=1, max_length=1000)] = Field(
        "region", description="one that comes with waypointctl, or a YAML file, relative to this one"
    )
    trials: Few = Field(200, description="of each of the suite's cases")
    seed: Annotated[int, Strict(), Field(ge=1, lt=2**32)] = Field(
        1000, description="of the trials; differs from evaluation.seed: the final evaluation must use other trials"
    )
    every: Count = Field(1_000_000, description="control steps between evaluations; the last step is also evaluated")
    stop_at: Rate | None = Field(None, description="end the training when this success rate is reached")


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Candidate(_Record):
    """A checkpoint that was evaluated.

    Attributes:
        steps: of its training.
        wall_time_s: spent on training until the evaluation was over, earlier sessions of a resumed one included.
        trials: of all cases together, > 0.
        successes: among them.
        falls: among them.
    """

    steps: int
    wall_time_s: float
    trials: int
    successes: int
    falls: int

    @property
    def success_rate(self) -> float:
        """The quantity that selects."""
        return self.successes / self.trials


class SelectionFile(_Record):
    """selection.json: what was evaluated, and how."""

    suite: str
    seed: int
    stop_at: float | None
    selected_steps: int
    candidates: list[Candidate]


class Selection:
    """The checkpoints of a run that were evaluated so far."""

    def __init__(self, recipe: SelectionRecipe, run: Path, steps: int, suite_name: str | None = None) -> None:
        """Continue from the run's record up to `steps`; 0 begins anew.

        Args:
            recipe: how checkpoints are evaluated.
            run: the run's folder.
            steps: of the training so far.
            suite_name: the suite's own name, to be shown; None: as the recipe has it, which may be a file.

        Raises:
            RecipeError: the record in the folder is damaged.
        """
        self.recipe = recipe
        self.suite_name = suite_name or recipe.suite
        self._path = run / SELECTION
        found = _read(self._path) if steps else []
        # If the newest checkpoint was removed, training repeats the steps after the one before it.
        self.candidates = [candidate for candidate in found if candidate.steps <= steps]

    @property
    def last_steps(self) -> int:
        """The step of the last candidate; 0 before the first."""
        return self.candidates[-1].steps if self.candidates else 0

    @property
    def best(self) -> Candidate:
        """The candidate with the most successes; at least one must exist.

        Of equals, the later one: it was trained longer and at a lower learning rate. Speed is not a tie-breaker: equals
        differ in it by chance.
        """
        return max(self.candidates, key=lambda candidate: (candidate.successes, candidate.steps))

    @property
    def met(self) -> bool:
        """Whether the success rate is reached at which training is to end."""
        target = self.recipe.stop_at
        return target is not None and bool(self.candidates) and self.best.success_rate >= target

    def is_due(self, steps: int, *, last: bool) -> bool:
        """Return whether a checkpoint at `steps`, which may be the last, is to be evaluated."""
        every = self.recipe.every
        return steps >= (self.last_steps // every + 1) * every or (last and self.last_steps != steps)

    def add(self, candidate: Candidate) -> None:
        """Add a candidate, and write all to the run's folder.

        Raises:
            OutputError: they cannot be written.
        """
        self.candidates.append(candidate)
        written = SelectionFile(
            suite=self.recipe.suite,
            seed=self.recipe.seed,
            stop_at=self.recipe.stop_at,
            selected_steps=self.best.steps,
            candidates=self.candidates,
        )
        write_whole(self._path, f"{written.model_dump_json(indent=2)}\n".encode(), "the record of the checkpoints")

    def record(self) -> SelectionRecord:
        """Return the record for the manifest of the selected policy."""
        best = self.best
        return SelectionRecord(
            suite=self.recipe.suite,
            seed=self.recipe.seed,
            trials=best.trials,
            successes=best.successes,
            candidates=len(self.candidates),
            last_step=self.last_steps,
            stop_at=self.recipe.stop_at,
        )


def with_record(policy: LoadedPolicy, record: SelectionRecord) -> LoadedPolicy:
    """Return a checkpoint's policy whose manifest states how it was selected."""
    manifest = policy.manifest
    training = manifest.training.model_copy(update={"selection": record})
    description = manifest.model_copy(update={"training": training})
    files = bundle_files(description, policy.files[NETWORK], policy.files[WEIGHTS])
    return load_policy_bytes(files, manifest.name)


def _read(path: Path) -> list[Candidate]:
    try:
        return SelectionFile.model_validate_json(
            read_input(path, RECORD_FILE, RecipeError, within=path.parent)
        ).candidates
    except (RecipeError, ValidationError) as error:
        if getattr(error, "problem", "") == NOT_THERE:
            return []  # killed before the first evaluation
        problem = "the record of the evaluated checkpoints cannot be read"
        hint = "Remove the file: then only later checkpoints are evaluated."
        raise RecipeError(problem, where=str(path), hint=hint) from error
