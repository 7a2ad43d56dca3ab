"""What `waypointctl init` writes is valid, and does what its comments say."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from tests.cli.flying import Program
from waypointctl.training.recipe_references import load_recipe_to_train

FILES = ("mission.yaml", "recipe.yaml", "suite.yaml")


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory, from which no policy is near."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_what_it_writes_is_valid_and_flies(empty: Path, program: Program) -> None:
    code, out, err = program("init", "work/first one")
    assert (code, err) == (0, "")
    assert sorted(path.name for path in (empty / "work" / "first one").iterdir()) == list(FILES)
    steps = out.splitlines()[out.splitlines().index("Next:") + 1 :]
    assert [step.split()[1] for step in steps] == ["validate", "run", "eval", "train"]
    assert "waypointctl run 'work/first one/mission.yaml'" in out
    for name in FILES:
        text = (empty / "work" / "first one" / name).read_text()
        assert text.count("#") > 5, f"{name} explains itself"
    assert program("fmt", "--check", "work/first one/mission.yaml")[0] == 0
    assert program("validate", "--strict", "work/first one/mission.yaml")[::2] == (0, "")
    code, out, _ = program("run", "--json", "work/first one/mission.yaml")
    assert (code, json.loads(out)["outcome"]) == (0, "success")


@pytest.mark.slow
def test_the_next_steps_do_what_they_say(empty: Path, program: Program) -> None:
    _, out, _ = program("init", ".")
    steps = [shlex.split(line)[1:] for line in out.splitlines() if line.startswith("  waypointctl ")]
    assert [step[0] for step in steps] == ["validate", "run", "eval", "train"]
    recipe = (
        (empty / "recipe.yaml").read_text().replace("trials: 50,", "trials: 1,").replace("trials: 100,", "trials: 1,")
    )
    (empty / "recipe.yaml").write_text(recipe)
    assert program(*steps[0])[0] == 0
    code, out, _ = program(*steps[2], "--trials", "2", "--json")
    assert code == 0
    assert json.loads(out)["suite"] == "first-suite"
    code, out, err = program(*steps[3], "--steps", "1", "--json")
    assert (code, json.loads(out)["outcome"]) == (0, "complete"), err
    assert json.loads(out)["selection"]["suite"] == "suite.yaml"
    (empty / "recipe.yaml").write_text(recipe.replace("# warm_start", "warm_start"))
    assert load_recipe_to_train(empty / "recipe.yaml").recipe.warm_start is not None


@pytest.mark.parametrize("name", FILES)
def test_nothing_is_replaced_and_nothing_else_is_written(empty: Path, program: Program, name: str) -> None:
    (empty / "work").mkdir()
    (empty / "work" / name).write_text("mine")
    code, out, err = program("init", "work")
    assert (code, out) == (2, "")
    assert f"work/{name} is already there; nothing was written" in err
    assert [path.name for path in (empty / "work").iterdir()] == [name]
    assert (empty / "work" / name).read_text() == "mine"


def test_a_link_that_leads_nowhere_is_not_replaced(empty: Path, program: Program) -> None:
    (empty / "mission.yaml").symlink_to("nowhere")
    assert program("init", ".")[0] == 2
    assert (empty / "mission.yaml").is_symlink()


@pytest.mark.parametrize("folder", ["a-file", "a-file/below", "x" * 300, "/proc/none"])
def test_a_folder_that_cannot_be_is_refused(empty: Path, program: Program, folder: str) -> None:
    (empty / "a-file").touch()
    code, out, err = program("init", folder)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert "Traceback" not in err


def test_json_names_the_files(empty: Path, program: Program) -> None:
    code, out, err = program("init", "new", "--json")
    assert code == 0
    assert json.loads(out) == {"folder": "new", "files": ["new/mission.yaml", "new/suite.yaml", "new/recipe.yaml"]}
    assert "Next:" in err
