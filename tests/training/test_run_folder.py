from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from waypointctl.errors import InputError, OutputError, RecipeError
from waypointctl.training.recipe_file import MODULES, require_packages
from waypointctl.training.run_folder import Places, newest_checkpoint, places


def begin(run: Path, *steps: int, at_s: int = 0) -> Path:
    """Make a run with checkpoints of some steps, the newest of them written at a time."""
    for step in steps:
        (run / "checkpoints" / f"step-{step:010d}").mkdir(parents=True)
    os.utime(run / "checkpoints" / f"step-{max(steps):010d}", (at_s, at_s))
    return run


def test_a_new_run_takes_the_first_name_that_is_free(tmp_path: Path) -> None:
    runs = tmp_path / "runs"
    taken = [places("ant", runs, None, resume=False) for _ in range(3)]
    assert taken == [Places(runs / name, runs / name) for name in ("ant", "ant-2", "ant-3")]


def test_a_policy_elsewhere_still_has_its_run(tmp_path: Path) -> None:
    runs, out = tmp_path / "runs", tmp_path / "policies" / "ant"
    assert places("ant", runs, out, resume=False) == Places(runs / "ant", out)
    assert not out.exists()


def test_out_among_the_runs_is_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert places("ant", Path("runs"), Path("runs/mine"), resume=False).run == Path("runs/mine")
    assert places("ant", Path("runs"), tmp_path / "runs" / "mine", resume=True).run == tmp_path / "runs" / "mine"


def test_the_run_that_was_worked_on_last_is_gone_on_with(tmp_path: Path) -> None:
    begin(tmp_path / "ant", 100, at_s=30)
    begin(tmp_path / "ant-2", 900, at_s=20)
    begin(tmp_path / "ant-10", 50, at_s=40)
    begin(tmp_path / "ant-hill", 1, at_s=99)
    begin(tmp_path / "antelope", 1, at_s=99)
    assert places("ant", tmp_path, None, resume=True).run == tmp_path / "ant-10"


def test_a_newest_run_without_a_checkpoint_is_not_passed_over_in_silence(tmp_path: Path) -> None:
    begin(tmp_path / "ant", 100, at_s=30)
    killed = tmp_path / "ant-2"
    killed.mkdir()
    with pytest.raises(RecipeError, match=r"the newest run .*ant-2 has no checkpoint\n  Name the run .*with --out"):
        places("ant", tmp_path, None, resume=True)
    assert places("ant", tmp_path, tmp_path / "ant", resume=True).run == tmp_path / "ant"
    # A run that was gone on with since the other was killed is the newest again.
    os.utime(killed, (20, 20))
    assert places("ant", tmp_path, None, resume=True).run == tmp_path / "ant"


def test_the_newest_checkpoint_is_the_one_of_the_most_steps(tmp_path: Path) -> None:
    run = begin(tmp_path / "run", 5, 12_345_678_901, 40)
    (run / "checkpoints" / ".step-0000000999.1.tmp").mkdir()
    (run / "checkpoints" / "step-copy").mkdir()
    assert newest_checkpoint(run) == run / "checkpoints" / "step-12345678901"
    assert newest_checkpoint(tmp_path) is None


@pytest.mark.parametrize("there", [True, False])
def test_no_run_to_go_on_with(tmp_path: Path, there: bool) -> None:
    if there:
        (tmp_path / "runs" / "ant").mkdir(parents=True)
    with pytest.raises(RecipeError, match=r"no run of 'ant' with a checkpoint .*\n  Train without --resume"):
        places("ant", tmp_path / "runs", None, resume=True)


def test_places_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    for runs, out in ((tmp_path / "file", None), (tmp_path / "runs", tmp_path / "file" / "a" / "b")):
        with pytest.raises(OutputError, match=r"file.*: the folder cannot be written: .*is a file\n  Give a path"):
            places("ant", runs, out, resume=False)
    assert not (tmp_path / "runs").exists()


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(OutputError, match="no permission"):
        places("ant", tmp_path / "runs", None, resume=False)


@pytest.mark.parametrize("module", MODULES)
def test_a_missing_package_is_named_with_the_command_that_installs_it(
    monkeypatch: pytest.MonkeyPatch, module: str
) -> None:
    require_packages()
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError, match=rf'not installed: {module}\n  .*pip install "\.\[train\]"'):
        require_packages()
