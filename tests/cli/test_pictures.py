"""Pictures as somebody at the command line meets them."""

from __future__ import annotations

import hashlib
import json
import os
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.flying import Program, start
from tests.drawing import require_rendering
from waypointctl.log.messages import Picture
from waypointctl.log.png import SOFTWARE, texts_of
from waypointctl.log.reader import open_log
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.sim.offscreen import NoRendering

SURVEY = """\
name: survey
seed: 4
policy: still
defaults: {tolerance: 3 m, observe: true}
waypoints:
  - {name: rock, position: [0 m, 0 m]}
  - {name: "there [/bold]", position: [2 m, 0.5 m]}
link: {delay: 0.1 s}
"""


@pytest.fixture
def field(yard: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a mission that observes."""
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    (yard / "survey.yaml").write_text(SURVEY)
    return yard


def fly(folder: Path) -> bytes:
    """Fly the mission in a process of its own; return its log."""
    done = start(folder, "run", "survey.yaml", "--out", "a.mcap", stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    out, err = done.communicate(timeout=120)
    assert done.returncode == 0, err
    assert b"Traceback" not in err  # of a driver that is gone when the program ends
    assert b"\npictures   2: waypointctl replay a.mcap --pictures FOLDER\n" in out
    return (folder / "a.mcap").read_bytes()


@pytest.fixture(scope="module")
def survey_log(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> bytes:
    """The log of a flight with two pictures."""
    require_rendering()
    folder = tmp_path_factory.mktemp("survey")
    make_policy(folder / "still", gain=0.0)
    (folder / "survey.yaml").write_text(SURVEY)
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("MUJOCO_GL", raising=False)
        return fly(folder)


@pytest.fixture
def survey(field: Path, survey_log: bytes) -> Path:
    """A folder with that log."""
    (field / "survey.mcap").write_bytes(survey_log)
    return field


@pytest.mark.slow
def test_two_processes_write_the_same_bytes(field: Path, survey_log: bytes) -> None:
    assert fly(field) == survey_log
    assert open_log(field / "a.mcap").count("/camera") == 2


def test_a_log_is_proved_where_another_renderer_is(survey: Path, program: Program) -> None:
    """Mesa's software renderer works with vectors of another width, and says so in its name."""
    picture = next(it for it in open_log(survey / "survey.mcap").messages(("/camera",)) if isinstance(it, Picture))
    if "llvmpipe" not in texts_of(picture.data)[SOFTWARE]:
        pytest.skip("only llvmpipe can be made another renderer")
    width = "256" if "128 bits" in texts_of(picture.data)[SOFTWARE] else "128"
    elsewhere = start(survey, "replay", "survey.mcap", "--verify", stdout=subprocess.PIPE, LP_NATIVE_VECTOR_WIDTH=width)
    out, _ = elsewhere.communicate(timeout=120)
    assert elsewhere.returncode == 0, out
    assert b"\n  not compared: 2 pictures: another renderer drew them\n" in out
    assert "\n  2 pictures, redrawn byte for byte\n" in program("replay", "survey.mcap", "--verify")[1]


def test_several_missions_have_the_same_pictures_as_one(survey: Path, program: Program) -> None:
    code, out, err = program("run", "survey.yaml", "easy.yaml", "--json")
    flights = json.loads(out)["missions"]
    assert code == 0
    assert [flight["pictures"] for flight in flights] == [2, 0]
    assert flights[0]["log_sha256"] == hashlib.sha256((survey / "survey.mcap").read_bytes()).hexdigest()
    assert "no pictures" not in err


@pytest.mark.parametrize("value", ["disable", "vulkan"])
def test_where_nothing_can_draw_it_flies_and_says_so_once(
    field: Path, program: Program, monkeypatch: pytest.MonkeyPatch, value: str
) -> None:
    monkeypatch.setenv("MUJOCO_GL", value)
    code, out, err = program("run", "survey.yaml", "--out", "log.mcap", "--json")
    found = json.loads(out)
    assert (code, found["outcome"], found["pictures"]) == (0, "success", 0)
    assert err.count(f"no pictures: MUJOCO_GL={value} ") == 1
    assert "Unset MUJOCO_GL" in err
    assert "/camera" not in open_log(field / "log.mcap").topics


def test_the_proof_of_a_log_without_pictures_says_so(
    field: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    assert program("run", "survey.yaml", "--out", "log.mcap")[0] == 0
    code, out, _ = program("replay", "log.mcap", "--verify")
    assert code == 0
    assert "  2 observations without a picture in the log\n" in out


def test_nothing_is_said_where_nothing_was_to_be_taken(
    yard: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    code, out, err = program("run", "easy.yaml", "--out", "log.mcap")
    assert code == 0
    assert "pictures" not in out + err


def test_the_proof_of_a_flight_without_observations_sets_up_nothing_that_draws(yard: Path, program: Program) -> None:
    assert program("run", "easy.yaml", "--out", "log.mcap")[0] == 0
    code = "import sys, waypointctl.cli.main as m\ntry: m.main()\nexcept SystemExit: print('OpenGL' in sys.modules)"
    command = [sys.executable, "-c", code, "replay", "log.mcap", "--verify"]
    done = subprocess.run(command, cwd=yard, capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.startswith("EXACT")
    assert done.stdout.endswith("False\n")
    assert done.stderr.strip() == ""


def test_the_pictures_are_written_as_files(survey: Path, program: Program) -> None:
    code, out, err = program("replay", "survey.mcap", "--verify", "--pictures", "seen/here")
    assert code == 0
    assert "2 pictures" in out
    names = ["01-rock.png", "02-there-bold.png"]
    assert err == "".join(f"written: seen/here/{name}\n" for name in names)
    assert sorted(path.name for path in (survey / "seen/here").iterdir()) == names
    assert all((survey / "seen/here" / name).read_bytes().startswith(b"\x89PNG\r\n") for name in names)
    assert program("replay", "survey.mcap", "--verify", "--pictures", "seen/here")[0] == 0


def test_a_picture_takes_the_place_of_a_picture_only(survey: Path, program: Program) -> None:
    (survey / "seen").mkdir()
    (survey / "seen" / "02-there-bold.png").write_text("notes")
    code, out, err = program("replay", "survey.mcap", "--pictures", "seen")
    assert (code, out) == (2, "")
    assert err == "error: seen/02-there-bold.png: already exists and is not a PNG\n  Name another file.\n"
    assert [path.name for path in (survey / "seen").iterdir()] == ["02-there-bold.png"]


def test_a_folder_that_cannot_be_is_refused_first(survey: Path, program: Program) -> None:
    code, out, err = program("replay", "survey.mcap", "--pictures", "survey.yaml")
    assert (code, out) == (2, "")
    assert err.startswith("error: survey.yaml: the folder cannot be written: this is a file")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission_is_refused_first(survey: Path, program: Program) -> None:
    (survey / "closed").mkdir()
    (survey / "closed").chmod(stat.S_IRUSR | stat.S_IXUSR)
    assert program("replay", "survey.mcap", "--pictures", "closed/seen")[0] == 2


def test_a_log_without_pictures_writes_none_and_says_so(yard: Path, program: Program) -> None:
    assert program("run", "easy.yaml", "--out", "log.mcap")[0] == 0
    code, _, err = program("replay", "log.mcap", "--verify", "--pictures", "seen")
    assert code == 0
    assert err == "the log has no pictures: no waypoint of this mission has `observe: true`\n"
    assert not (yard / "seen").exists()


def test_a_log_without_pictures_says_that_no_renderer_was_available(
    field: Path, program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    def absent(*_: object) -> None:
        raise NoRendering("no renderer")

    monkeypatch.setattr("waypointctl.sim.camera.MountedCamera", absent)
    assert program("run", "survey.yaml", "--out", "log.mcap")[0] == 0
    err = program("replay", "log.mcap", "--verify", "--pictures", "seen")[2]
    assert err == "the log has no pictures: no renderer was available during the flight\n"


def test_a_log_without_pictures_says_that_no_observation_was_reached(field: Path, program: Program) -> None:
    mission = (field / "survey.yaml").read_text().replace("tolerance: 3 m", "tolerance: 10 cm, timeout: 0.2 s")
    (field / "survey.yaml").write_text(mission.replace("[0 m, 0 m]", "[9 m, 0 m]"))
    assert program("run", "survey.yaml", "--out", "log.mcap")[0] == 1
    err = program("replay", "log.mcap", "--verify", "--pictures", "seen")[2]
    assert err == "the log has no pictures: the flight ended before the first observation\n"


def test_shown_again_it_writes_no_pictures(survey: Path, program: Program) -> None:
    code, out, err = program("replay", "survey.mcap", "--rate", "2", "--pictures", "seen")
    assert (code, out) == (2, "")
    assert "--png or --pictures" in err.replace("\n", " ").replace("│", "").replace("  ", " ")


def test_a_complete_log_says_how_many_it_has_when_it_is_to_be_resumed(survey: Path, program: Program) -> None:
    code, out, _ = program("run", "--resume", "survey.mcap", "--json")
    assert (code, json.loads(out)["pictures"]) == (0, 2)
