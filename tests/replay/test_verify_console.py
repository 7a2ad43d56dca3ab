"""Flights with a person at the console, or interrupted by one, are proven like others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from tests.flight.scripted_lines import ScriptedLines
from tests.replay.rewriting import Flown
from waypointctl.flight.fly import fly
from waypointctl.log.messages import ConsoleInput, Message
from waypointctl.mission.files import MissionFile, parse_mission
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.verify import Verdict, verify
from waypointctl.units import NS_PER_S

MISSION = b"""\
name: session
policy: ./policy
seed: 4
defaults: {timeout: 3 s}
waypoints:
  - {name: here, position: [0.2 m, 0 m], tolerance: 10 m, hold: 1 s}
  - {name: far, position: [90 m, 0 m]}
link:
  up: {delay: 130 ms, jitter: 20 ms, loss: 10 %}
  down: {delay: 90 ms, jitter: 60 ms}
"""
LINES = (
    (0.5, "hold"),
    (1.013, "resume"),
    (2.0, "tolerance 20"),
    (2.0, "goto 0.5 0.5"),
    (12.01, "home"),
    (14.0, "quit"),
)


def session(folder: Path, policy: LoadedPolicy, *lines: tuple[float, str]) -> Flown:
    mission_file = MissionFile(parse_mission(MISSION, "mission.yaml"), MISSION, folder / "mission.yaml")
    fly(mission_file, policy, log=folder / "session.mcap", console=ScriptedLines(*lines))
    return Flown(mission_file, policy, folder / "session.mcap")


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Flown:
    folder = tmp_path_factory.mktemp("session")
    return session(folder, make_policy(folder / "policy", gain=0.0), *LINES)


def retyped(flown: Flown, before: str, after: str) -> list[Message]:
    """Return the session's messages with one line typed otherwise."""
    return [
        replace(message, text=after) if isinstance(message, ConsoleInput) and message.text == before else message
        for message in flown.messages
    ]


def test_a_session_is_replayed_exactly_also_where_physics_slept(flown: Flown) -> None:
    typed = [message for message in flown.messages if isinstance(message, ConsoleInput)]
    assert [message.text for message in typed] == [text for _, text in LINES]
    assert typed[4].time_ns == 12_020_000_000
    found = verify(flown.path)
    assert found.verdict is Verdict.EXACT, found.reason
    assert "6 lines typed at the console, each at its logged time" in found.checks


@pytest.mark.parametrize("line", ["goto 0.5 0.6", "quit", "fly me to the moon"])
def test_a_line_that_was_not_typed_is_found(flown: Flown, tmp_path: Path, line: str) -> None:
    path = flown.rewritten(tmp_path / "other.mcap", retyped(flown, "goto 0.5 0.5", line))
    found = verify(path)
    assert found.verdict is Verdict.DIVERGED
    assert found.first_divergence is not None


def test_a_line_that_is_taken_out_is_found(flown: Flown, tmp_path: Path) -> None:
    kept = [m for m in flown.messages if not (isinstance(m, ConsoleInput) and m.text == "hold")]
    assert verify(flown.rewritten(tmp_path / "other.mcap", kept)).verdict is Verdict.DIVERGED


def test_a_line_that_is_moved_is_found(flown: Flown, tmp_path: Path) -> None:
    moved = [
        replace(m, time_ns=m.time_ns + 20_000_000) if isinstance(m, ConsoleInput) and m.text == "hold" else m
        for m in flown.messages
    ]
    assert verify(flown.rewritten(tmp_path / "other.mcap", moved)).verdict is Verdict.DIVERGED


@pytest.mark.parametrize("at_s", [0.5, 9.0, 13.013])
def test_an_interrupted_session_is_replayed_exactly(
    tmp_path: Path, make_policy: Callable[..., LoadedPolicy], at_s: float
) -> None:
    now_ns = 0

    class Typist(ScriptedLines):
        """Its interruption wakes a flight that sleeps, as Ctrl-C does."""

        def lines(self, at_ns: int) -> Iterator[str]:
            nonlocal now_ns
            now_ns = at_ns
            return super().lines(at_ns)

        def asleep(self, at_ns: int, until_ns: int) -> int:
            return min(super().asleep(at_ns, until_ns), round(at_s * NS_PER_S))

    mission_file = MissionFile(parse_mission(MISSION, "mission.yaml"), MISSION, tmp_path / "mission.yaml")
    policy = make_policy(tmp_path / "policy", gain=0.0)
    result = fly(
        mission_file,
        policy,
        log=tmp_path / "session.mcap",
        console=Typist(*LINES),
        interrupted=lambda: now_ns >= at_s * NS_PER_S,
    )
    assert result.outcome == "interrupted"
    assert 0 <= result.sim_time_ns - at_s * NS_PER_S < 20_000_000
    found = verify(tmp_path / "session.mcap")
    assert found.verdict is Verdict.EXACT, found.reason
