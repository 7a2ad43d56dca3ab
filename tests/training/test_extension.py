"""A run extended by a longer recipe ends where that recipe ends from nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.training.scores import NEAR
from tests.training.tiny import RECIPE, tiny_recipe, trained, weights_of
from waypointctl.errors import RecipeError
from waypointctl.training.checkpoint import extend
from waypointctl.training.progress import read_progress
from waypointctl.training.recipe_file import RecipeFile
from waypointctl.training.run_folder import checkpoints
from waypointctl.training.selection import SELECTION, SelectionFile

SELECTING = "selection: {suite: near.yaml, trials: 2, seed: 50, every: 300}\n"
MORE = "  - {steps: 384, learning_rate: [2.0e-4, 1.0e-5], reward: {orientation_penalty: 3}, entropy: [0.01, 0.0]}\n"
LONGER = RECIPE.replace("checkpoint_steps", f"{MORE}checkpoint_steps") + SELECTING


def recipe_in(folder: Path, text: str) -> RecipeFile:
    folder.mkdir()
    (folder / "near.yaml").write_text(NEAR)
    return tiny_recipe(folder, text)


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a complete run by the short recipe."""
    folder = tmp_path_factory.mktemp("short")
    trained(recipe_in(folder / "recipe", RECIPE + SELECTING), folder / "run")
    return folder / "run"


def test_it_ends_in_the_weights_of_the_longer_recipe_from_nothing(short: Path, tmp_path: Path) -> None:
    longer = recipe_in(tmp_path / "longer", LONGER)
    whole = trained(longer, tmp_path / "whole")
    before = sorted((path, path.stat().st_mtime_ns) for path in short.rglob("*") if path.name != ".lock")

    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "train.yaml").hardlink_to(short.parent / "recipe" / "recipe.yaml")
    own = (short.parent / "recipe" / "recipe.yaml").read_bytes()

    goes_on = extend(longer, short, tmp_path / "run", threads=1)

    assert (short.parent / "recipe" / "recipe.yaml").read_bytes() == own  # a new file took the name, whole
    assert (tmp_path / "run" / "train.yaml").read_bytes() == longer.source
    assert 256 <= goes_on < 1024  # not from the short recipe's end, whose last update was at its own rate
    extended = trained(longer, tmp_path / "run", resume=True)
    assert weights_of(tmp_path / "run") == weights_of(tmp_path / "whole")
    assert extended.steps == whole.steps == 1408
    assert [folder.name for _, folder in checkpoints(tmp_path / "run")] == [
        folder.name for _, folder in checkpoints(tmp_path / "whole")
    ]
    records = [one.policy.manifest.training.model_copy(update={"wall_time_s": 0.0}) for one in (extended, whole)]
    assert records[0] == records[1]
    assert candidates(tmp_path / "run") == candidates(tmp_path / "whole")
    rows = [[(row.steps, row.mean_reward) for row in read_progress(tmp_path / run)] for run in ("run", "whole")]
    assert rows[0] == rows[1]
    assert before == sorted((path, path.stat().st_mtime_ns) for path in short.rglob("*") if path.name != ".lock")


def candidates(run: Path) -> list[tuple[int, int]]:
    found = SelectionFile.model_validate_json((run / SELECTION).read_bytes())
    return [(one.steps, one.successes) for one in found.candidates]


@pytest.mark.parametrize(
    ("was", "becomes", "named"),
    [
        ("seed: 7", "seed: 8", "another seed"),
        ("hidden: [16, 16]", "hidden: [16]", "another network"),
        ("count: 2", "count: 3", "another course"),
        ("trials: 2", "trials: 3", "another selection"),
        ("steps: 640", "steps: 768", r"another phases\[0\]"),
    ],
)
def test_another_training_is_refused(short: Path, tmp_path: Path, was: str, becomes: str, named: str) -> None:
    other = recipe_in(tmp_path / "other", LONGER.replace(was, becomes))
    with pytest.raises(RecipeError, match=named):
        extend(other, short, tmp_path / "run", threads=1)
    assert not (tmp_path / "run").exists()


def test_a_phase_that_differs_later_leaves_the_part_before_it(short: Path, tmp_path: Path) -> None:
    other = recipe_in(tmp_path / "other", LONGER.replace("fall: 50", "fall: 60"))
    assert extend(other, short, tmp_path / "run", threads=1) < 640


def test_a_folder_that_is_no_run_is_refused(tmp_path: Path) -> None:
    longer = recipe_in(tmp_path / "longer", LONGER)
    with pytest.raises(RecipeError):
        extend(longer, tmp_path / "nowhere", tmp_path / "run")
