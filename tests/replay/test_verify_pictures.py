"""Pictures are part of the proof where the same renderer is, and are left out of it where it is not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.drawing import require_rendering
from tests.replay.pictured import fly_survey, repainted, with_picture
from tests.replay.rewriting import Flown
from waypointctl.log.messages import Message, Picture
from waypointctl.log.png import to_png
from waypointctl.log.reader import open_log
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.flight_log import names_of, pictures_in
from waypointctl.replay.verify import Verdict, Verification, verify, verify_log

Change = Callable[[Picture], list[Message]]


@pytest.fixture(scope="module")
def survey(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Flown:
    """A flight with two pictures; not to be changed."""
    require_rendering()
    folder = tmp_path_factory.mktemp("survey")
    return fly_survey(folder, make_policy(folder / "policy", gain=0.0))


@pytest.fixture
def changed(survey: Flown, tmp_path: Path) -> Callable[[int, Change], Verification]:
    """Prove the flight with another message, or none, in the place of a picture."""

    def prove(number: int, change: Change) -> Verification:
        return verify(survey.rewritten(tmp_path / "changed.mcap", with_picture(survey, number, change)))

    return prove


def about_pictures(found: Verification) -> list[str]:
    return [line for line in (*found.checks, *found.not_compared) if "picture" in line]


def test_the_pictures_are_drawn_again(survey: Flown) -> None:
    found = verify(survey.path)
    assert found.verdict is Verdict.EXACT
    assert about_pictures(found) == ["2 pictures, redrawn byte for byte"]


@pytest.mark.parametrize("number", [0, 1])
def test_a_pixel_that_was_changed_diverges(changed: Callable[[int, Change], Verification], number: int) -> None:
    found = changed(number, lambda picture: [repainted(picture)])
    where = found.first_divergence
    assert (found.verdict, where and (where.topic, where.component)) == (Verdict.DIVERGED, ("/camera", "data"))
    assert where is not None
    assert " bytes, " in where.logged
    assert " bytes, " in where.replayed
    assert len(where.logged) < 60


@pytest.mark.parametrize("at", [3, 60, -20])
def test_a_bit_that_was_flipped_diverges(changed: Callable[[int, Change], Verification], at: int) -> None:
    def flipped(picture: Picture) -> list[Message]:
        data = bytearray(picture.data)
        data[at] ^= 4
        return [replace(picture, data=bytes(data))]

    found = changed(1, flipped)
    assert found.verdict is Verdict.DIVERGED
    assert found.first_divergence is not None
    assert found.first_divergence.topic == "/camera"
    assert "PNG" in found.first_divergence.replayed


@pytest.mark.parametrize("field", ["time_ns", "frame_id", "format"])
def test_what_is_said_of_a_picture_is_compared(changed: Callable[[int, Change], Verification], field: str) -> None:
    other: Any = {"time_ns": 7, "frame_id": "x", "format": "jpeg"}[field]
    found = changed(0, lambda picture: [repainted(replace(picture, **{field: other}), "elsewhere")])
    assert found.verdict is Verdict.DIVERGED
    assert found.first_divergence is not None
    assert (found.first_divergence.topic, found.first_divergence.component) == ("/camera", field)


def test_a_picture_of_nothing_diverges(changed: Callable[[int, Change], Verification]) -> None:
    found = changed(0, lambda picture: [picture, picture])
    assert found.verdict is Verdict.DIVERGED


def test_another_renderer_is_no_divergence(changed: Callable[[int, Change], Verification]) -> None:
    found = changed(0, lambda picture: [repainted(picture, "a graphics card, OpenGL 9")])
    assert found.verdict is Verdict.EQUIVALENT, found
    assert about_pictures(found) == ["1 picture, redrawn byte for byte", "1 picture: another renderer drew it"]
    assert found.not_compared == ("1 picture: another renderer drew it",)
    assert "byte for byte" in found.checks[-1]  # the file as a whole


def test_where_nothing_can_draw_the_rest_is_proved(survey: Flown, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disable")
    found = verify(survey.path)
    assert found.verdict is Verdict.EQUIVALENT
    assert found.not_compared == ("2 pictures: no renderer here: MUJOCO_GL=disable turns rendering off",)


def test_what_a_log_says_of_its_program_lets_no_picture_be_changed(survey: Flown, tmp_path: Path) -> None:
    messages = with_picture(survey, 0, lambda picture: [repainted(picture)])
    path = survey.rewritten(tmp_path / "other.mcap", messages, metadata={"source": "0" * 12})
    found = verify(path)
    assert found.verdict is Verdict.DIVERGED
    assert found.first_divergence is not None
    assert found.first_divergence.topic == "/camera"
    assert "the other program may be the cause" in found.reason


def test_a_picture_that_is_not_there_is_said(changed: Callable[[int, Change], Verification]) -> None:
    found = changed(1, lambda picture: [])
    assert found.verdict is Verdict.EQUIVALENT
    assert about_pictures(found) == [
        "1 picture, redrawn byte for byte",
        "1 observation without a picture in the log",
    ]


def test_a_log_without_its_pictures_is_not_what_is_written_where_something_can_draw(
    survey: Flown, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    messages = [message for message in survey.messages if not isinstance(message, Picture)]
    path = survey.rewritten(tmp_path / "without.mcap", messages)
    found = verify(path)
    assert (found.verdict, found.not_compared) == (
        Verdict.EQUIVALENT,
        ("2 observations without a picture in the log",),
    )
    monkeypatch.setenv("MUJOCO_GL", "disable")
    assert verify(path).verdict is Verdict.EXACT


def test_their_files_have_safe_names(survey: Flown) -> None:
    log = open_log(survey.path)
    files = pictures_in(log)
    assert [file.name for file in files] == ["01-rock.png", "02-a-b-ö.png"]
    assert [file.data for file in files] == [it.data for it in survey.messages if isinstance(it, Picture)]
    assert verify_log(log).verdict is Verdict.EXACT


@pytest.mark.parametrize("letter", ["a", "ö", "\U00010348"])
def test_the_longest_name_is_still_one_of_a_file(letter: str) -> None:
    picture = to_png(np.zeros((2, 2, 3), np.uint8), 60 * letter, "here")
    (name,) = names_of([Picture(0, "camera", "png", picture)])
    assert name.startswith(f"01-{letter}")
    assert len(name.encode()) <= 200
