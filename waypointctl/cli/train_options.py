"""The options of `waypointctl train`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from waypointctl.display_text import shell_word

if TYPE_CHECKING:
    from waypointctl.training.recipe_file import RecipeFile

RUNS: Final = Path("runs")


@dataclass(frozen=True, slots=True)
class TrainOptions:
    """The command's arguments; what is None was not given.

    Attributes:
        recipe: its file.
        out: the folder of the policy, or of the group of seeds.
        runs: the folder of all runs.
        resume: continue a run or a group of seeds.
        extend: the run to continue with a longer recipe.
        steps: of all phases together.
        seed: in place of the recipe's.
        seeds: how many, or which.
        stop_at: the success rate of a checkpoint that ends the training.
        threads: of physics and network; 0 is the default, or those of the run that is resumed.
        json: print one JSON object.
        allow_plugins: execute the recipe's plugins.
    """

    recipe: Path
    out: Path | None = None
    runs: Path = RUNS
    resume: bool = False
    extend: Path | None = None
    steps: int | None = None
    seed: int | None = None
    seeds: str | None = None
    stop_at: float | None = None
    threads: int = 0
    json: bool = False
    allow_plugins: bool = False

    def load(self) -> RecipeFile:
        """Return the recipe as its file has it; whatever is missing is reported before anything is written.

        Raises:
            InputError: packages are missing, the recipe or what it refers to is wrong or not there, or it cannot be
                given the target of --stop-at.
        """
        from waypointctl.training.recipe_file import load_recipe, require_packages, with_plugins
        from waypointctl.training.recipe_references import load_recipe_to_train

        # A run that is resumed has what its recipe refers to.
        recipe_file = load_recipe(self.recipe) if self.resume else load_recipe_to_train(self.recipe)
        require_packages()
        recipe_file = with_plugins(recipe_file, allowed=self.allow_plugins)
        if not self.resume:
            self.applied_to(recipe_file)
        return recipe_file

    def applied_to(self, recipe_file: RecipeFile, began: RecipeFile | None = None) -> RecipeFile:
        """Return a recipe with the steps, seed and target of the options.

        Args:
            recipe_file: as its file has it; phases are shortened or stretched from there.
            began: as the resumed run began; None: nothing has begun.

        Raises:
            RecipeError: the recipe cannot be given the target.
        """
        from waypointctl.errors import RecipeError

        recipe = (began or recipe_file).recipe
        if self.steps is not None:
            scaled = recipe_file.recipe.scaled_to(self.steps)
            recipe = recipe.with_phase_steps([phase.steps for phase in scaled.phases])
        if self.seed is not None:
            recipe = recipe.model_copy(update={"seed": self.seed})
        if self.stop_at is not None:
            try:
                recipe = recipe.stopping_at(self.stop_at)
            except ValueError as error:
                hint = "Give the recipe a selection with a seed of its own."
                where = recipe_file.place("evaluation", "seed")
                raise RecipeError(f"--stop-at: {error}", where=where, hint=hint) from error
        return replace(recipe_file, recipe=recipe)

    @property
    def resume_command(self) -> str:
        """The command that continues the training."""
        options = [
            ("--seeds", self.seeds),
            ("--out", self.out),
            ("--runs", self.runs if self.runs != RUNS else None),
            ("--threads", self.threads or None),
        ]
        given = [part for name, value in options if value is not None for part in (name, str(value))]
        flags = ["--allow-plugins"] if self.allow_plugins else []
        return " ".join(map(shell_word, ["waypointctl", "train", str(self.recipe), *given, *flags, "--resume"]))
