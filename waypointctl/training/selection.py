"""Which checkpoint becomes the policy: each is tested, the most successful is chosen.

What has been found stands in the run's selection.json. When the next test is due follows from that alone, so that a
training that is killed and resumed tests the very checkpoints that an undisturbed one does.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

from pydantic import BaseModel, ConfigDict, ValidationError

from waypointctl.errors import RecipeError
from waypointctl.input_file import NOT_THERE, RECORD_FILE, read_input
from waypointctl.paths import write_whole
from waypointctl.policy.bundle import LoadedPolicy, load_policy_bytes
from waypointctl.policy.manifest import NETWORK, WEIGHTS, SelectionRecord
from waypointctl.policy.write import bundle_files
from waypointctl.training.recipe_selection import SelectionRecipe

SELECTION: Final = "selection.json"


class _Record(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class Candidate(_Record):
    """A checkpoint that was tested.

    Attributes:
        steps: of its training.
        wall_time_s: spent on training until the test was over, earlier sessions of a resumed one counted in.
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
        """What it is chosen by."""
        return self.successes / self.trials


class SelectionFile(_Record):
    """selection.json: what was tested, and how."""

    suite: str
    seed: int
    stop_at: float | None
    chosen_steps: int
    candidates: list[Candidate]


class Selection:
    """The checkpoints of a run that were tested so far."""

    def __init__(self, recipe: SelectionRecipe, run: Path, steps: int, suite_name: str | None = None) -> None:
        """Go on from what the run's folder has of the time until `steps`; 0 begins anew.

        Args:
            recipe: how checkpoints are tested.
            run: the run's folder.
            steps: that training has come to.
            suite_name: the suite's own name, for people; None: as the recipe has it, which may be a file.

        Raises:
            RecipeError: the record in the folder is damaged.
        """
        self.recipe = recipe
        self.suite_name = suite_name or recipe.suite
        self._path = run / SELECTION
        found = _read(self._path) if steps else []
        # Where the newest checkpoint was removed, training passes once more over what followed the one before.
        self.candidates = [candidate for candidate in found if candidate.steps <= steps]

    @property
    def last_steps(self) -> int:
        """Where the last candidate was taken; 0 before the first."""
        return self.candidates[-1].steps if self.candidates else 0

    @property
    def best(self) -> Candidate:
        """The candidate with the most successes; there has to be one.

        The later of equals, which has learnt longer and at a lower rate. Speed is no tie-breaker: what is to be quick
        is for the reward to say, and equals differ in it by chance.
        """
        return max(self.candidates, key=lambda candidate: (candidate.successes, candidate.steps))

    @property
    def met(self) -> bool:
        """Whether the success rate is reached at which training is to end."""
        target = self.recipe.stop_at
        return target is not None and bool(self.candidates) and self.best.success_rate >= target

    def due(self, steps: int) -> bool:
        """Return whether a checkpoint at `steps` is to be tested."""
        every = self.recipe.every
        return steps >= (self.last_steps // every + 1) * every

    def add(self, candidate: Candidate) -> None:
        """Take one candidate more, and write all to the run's folder.

        Raises:
            OutputError: they cannot be written.
        """
        self.candidates.append(candidate)
        written = SelectionFile(
            suite=self.recipe.suite,
            seed=self.recipe.seed,
            stop_at=self.recipe.stop_at,
            chosen_steps=self.best.steps,
            candidates=self.candidates,
        )
        write_whole(self._path, f"{written.model_dump_json(indent=2)}\n".encode(), "the record of the checkpoints")

    def record(self) -> SelectionRecord:
        """Return what the manifest of the chosen policy says of it."""
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
    """Return a checkpoint's policy with a manifest that says how it was chosen."""
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
            return []  # killed before the first test
        problem = "the record of the checkpoints that were tested cannot be read"
        hint = "Remove the file: the checkpoints from now on are tested."
        raise RecipeError(problem, where=str(path), hint=hint) from error
