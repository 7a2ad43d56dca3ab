"""A flight with pictures that was killed goes on: the pictures it had are drawn again, and the rest are taken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.drawing import require_rendering
from tests.replay.pictured import fly_survey, repainted, with_picture
from tests.replay.rewriting import Flown
from waypointctl.errors import LogError
from waypointctl.flight.outcome import FlightResult
from waypointctl.log.messages import Message, Picture
from waypointctl.log.reader import open_log
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.resume import go_on, unfinished


@dataclass(frozen=True)
class Survey:
    """A flight with two pictures that nobody killed."""

    flown: Flown
    data: bytes

    def cut(self, folder: Path, share: float) -> Path:
        """Return the .part of the flight, killed when it had written such a share of its messages."""
        begin = open_log(self.flown.path).index.chunks[0].offset
        part = folder / "flight.mcap.part"
        part.write_bytes(self.data[: round(begin + share * (len(self.data) - begin))])
        return part


@pytest.fixture(scope="module")
def survey(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Survey:
    """A flight; not to be changed."""
    require_rendering()
    folder = tmp_path_factory.mktemp("survey")
    flown = fly_survey(folder, make_policy(folder / "policy", gain=0.0))
    return Survey(flown, flown.path.read_bytes())


def nothing(message: Message) -> None:
    pass


def resumed(path: Path) -> FlightResult:
    with unfinished(path) as flight:
        assert flight is not None
        return go_on(flight, again=nothing, watch=nothing)


def kept(part: Path) -> int:
    """Return how many pictures are left of a flight that was killed."""
    return open_log(part, allow_truncated=True).count("/camera")


@pytest.mark.parametrize("share", [0.1, 0.6, 0.99])
def test_wherever_it_was_cut_the_finished_log_is_the_same_bytes(survey: Survey, tmp_path: Path, share: float) -> None:
    result = resumed(survey.cut(tmp_path, share))
    assert (tmp_path / "flight.mcap").read_bytes() == survey.data
    assert (result.pictures, result.no_pictures) == (2, "")


def test_the_cuts_leave_every_number_of_pictures(survey: Survey, tmp_path: Path) -> None:
    assert {kept(survey.cut(tmp_path, share)) for share in (0.1, 0.6, 0.99)} == {0, 1, 2}


def test_what_nothing_can_draw_again_is_kept_and_no_more_is_taken(
    survey: Survey, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    part = survey.cut(tmp_path, 0.6)
    assert kept(part) == 1
    monkeypatch.setenv("MUJOCO_GL", "disable")
    result = resumed(part)
    assert (result.pictures, result.no_pictures.splitlines()[0]) == (1, "MUJOCO_GL=disable turns rendering off")
    found = [it for it in open_log(tmp_path / "flight.mcap").messages() if isinstance(it, Picture)]
    assert found == [next(it for it in survey.flown.messages if isinstance(it, Picture))]


def test_a_picture_that_was_altered_is_refused(survey: Survey, tmp_path: Path) -> None:
    messages = with_picture(survey.flown, 0, lambda picture: [repainted(picture)])
    path = survey.flown.rewritten(tmp_path / "flight.mcap", messages)
    part = path.rename(tmp_path / "flight.mcap.part")
    part.write_bytes(part.read_bytes()[:-5])
    with pytest.raises(LogError, match=r"diverges from it .* on /camera, data"):
        resumed(part)
