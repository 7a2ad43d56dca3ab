"""A flight that another version of the program began: noted, and continued only if the flight is the same."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

from tests.cli.flying import Program
from tests.log.fake_flight import bits
from tests.replay.rewriting import Flown, altered, fly_once
from waypointctl.flight.header import platform_facts
from waypointctl.log.messages import Message, State
from waypointctl.log.reader import open_log
from waypointctl.policy.bundle import LoadedPolicy

OLDER = {"version_waypointctl": "0.0.9", "source": "0123456789ab"}


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Flown:
    folder: Path = tmp_path_factory.mktemp("flight")
    return fly_once(folder, make_policy(folder / "policy", seed=7))


def killed(flown: Flown, folder: Path, metadata: dict[str, str], messages: Iterable[Message] | None = None) -> Path:
    """Return the .part of the flight as another program would have left it."""
    whole = flown.rewritten(folder / "whole.mcap", messages, metadata=metadata)
    part = folder / "flight.mcap.part"
    part.write_bytes(whole.read_bytes()[: open_log(whole).index.chunks[-1].offset])
    return part


def test_the_other_program_is_named_and_the_flight_gone_on_with(flown: Flown, tmp_path: Path, program: Program) -> None:
    part = killed(flown, tmp_path, OLDER)
    source = platform_facts()["source"]
    _, _, err = program("run", "--resume", str(part))
    assert err.startswith(
        f"note: {part} was made elsewhere (waypointctl was 0.0.9 and is {platform_facts()['version_waypointctl']}, "
        f"waypointctl's source was 0123456789ab and is {source}): it continues only if the flight is bit for bit"
    )
    finished = open_log(tmp_path / "flight.mcap")
    assert finished.metadata["source"] == source
    assert [bits(message) for message in finished.messages()] == [bits(message) for message in flown.messages]


def test_of_the_same_program_nothing_is_said(flown: Flown, tmp_path: Path, program: Program) -> None:
    _, _, err = program("run", "--resume", str(killed(flown, tmp_path, {})))
    assert "note:" not in err
    assert (tmp_path / "flight.mcap").read_bytes() == flown.path.read_bytes()


def test_a_flight_that_is_another_one_here_is_refused_with_both_programs(
    flown: Flown, tmp_path: Path, program: Program
) -> None:
    messages = flown.messages
    at = [index for index, message in enumerate(messages) if isinstance(message, State)][9]
    messages[at] = altered(messages[at], "qvel", 3)
    part = killed(flown, tmp_path, OLDER, messages)
    before = part.read_bytes()
    code, out, err = program("run", "--resume", str(part))
    assert (code, out) == (2, "")
    assert "cannot be resumed: the simulation diverges from it at step 9 on /state, qvel[3]: logged " in err
    assert "It was made elsewhere (waypointctl was 0.0.9 and is " in err
    assert "The log is unchanged" in err
    assert part.read_bytes() == before
    assert not list(tmp_path.glob("*resumed*"))
