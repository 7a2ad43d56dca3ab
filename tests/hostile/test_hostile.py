"""A few hostile inputs through the command line; bench/hostile_bundles.py tries as many as one likes."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.hostile.archives import ARCHIVES
from tests.hostile.bundles import FAMILIES, Family, Sound, using, yard
from tests.hostile.logs import LOGS
from tests.hostile.mutation import KINDS, SECRET
from tests.hostile.sound import sound_archive, sound_files, sound_log
from waypointctl.cli.main import main

EACH = 1  # attempts of each family
Try = Callable[[tuple[str, ...], Path], tuple[int, str]]


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Sound:
    folder: Path = tmp_path_factory.mktemp("sound")
    return sound_archive(folder, sound_log(folder, sound_files(folder)))


@pytest.fixture
def attempt(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Try:
    """Run a command in this process; return its exit code and what it printed."""

    def run(arguments: tuple[str, ...], folder: Path) -> tuple[int, str]:
        monkeypatch.chdir(folder)
        monkeypatch.setattr(sys, "argv", ["waypointctl", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        printed = "".join(capfd.readouterr())
        return int(ended.value.code or 0), printed

    return run


@pytest.mark.parametrize("number", range(EACH))
@pytest.mark.parametrize(
    "family", [*FAMILIES, *LOGS, *ARCHIVES], ids=lambda family: f"{family.__module__}.{family.__name__}"
)
def test_what_is_hostile_is_used_or_refused(
    tmp_path: Path, sound: Sound, attempt: Try, family: Family, number: int
) -> None:
    folder = tmp_path / "yard"
    folder.mkdir()
    made = family(random.Random(f"{family.__name__}/{number}"), folder, sound)
    code, printed = attempt(made.arguments, made.folder)
    assert code in made.may, made.name
    assert made.says in printed
    assert f"{SECRET}\n" not in printed
    assert "Traceback" not in printed


@pytest.mark.parametrize("kind", sorted(KINDS))
@pytest.mark.parametrize("name", ["manifest.json", "policy.onnx", "weights.safetensors", "jitter.txt", "plan.ionrc"])
def test_a_file_of_another_kind_is_refused_by_its_name(
    tmp_path: Path, sound: Sound, attempt: Try, name: str, kind: str
) -> None:
    folder = tmp_path / "yard"
    folder.mkdir()
    path = (folder if (folder / name).suffix in (".txt", ".ionrc") else yard(folder, sound)) / name
    if path.parent == folder:
        yard(folder, sound)
    path.unlink()
    KINDS[kind](path)
    code, printed = attempt(("run", "mission.yaml", "--out", "log.mcap"), folder)
    assert code == 2
    assert name in printed
    assert not (folder / "log.mcap").exists()


def test_what_is_sound_is_used(tmp_path: Path, sound: Sound, attempt: Try) -> None:
    """Otherwise everything would be refused, and nothing tried."""
    for number in range(7):
        folder = tmp_path / str(number)
        folder.mkdir()
        yard(folder, sound)
        code, printed = attempt(using(random.Random(number)), folder)
        assert code in (0, 1), printed
