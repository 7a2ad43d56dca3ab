"""Logs of policies that are no bundle: a class of somebody's own."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.policy.recurrent import Recurrent
from tests.replay.rewriting import Flown, altered
from waypointctl.errors import LogError, PolicyError
from waypointctl.flight.fly import fly
from waypointctl.flight.outcome import FlightResult
from waypointctl.log.messages import Action, GroundControl
from waypointctl.log.reader import open_log
from waypointctl.mission.files import MissionFile, parse_mission
from waypointctl.policy.protocol import Policy
from waypointctl.replay.resume import unfinished
from waypointctl.replay.verify import Verdict, verify

SOURCE = b"""
name: own
policy: none
autonomy: mission
link: {delay: 40 ms}
waypoints: [{position: [30 m, 0 m], timeout: 2 s}]
"""


def flown(path: Path, autonomy: str = "mission", policy: Policy | None = None) -> FlightResult:
    source = SOURCE.replace(b"mission\nlink", f"{autonomy}\nlink".encode())
    mission_file = MissionFile(parse_mission(source, "own.yaml"), source, path.with_name("own.yaml"))
    return fly(mission_file, policy or Recurrent(), log=path)


@pytest.mark.parametrize("autonomy", ["mission", "joint"])
def test_all_but_its_actions_is_proven(tmp_path: Path, autonomy: str) -> None:
    path = tmp_path / "own.mcap"
    result = flown(path, autonomy)
    assert (result.log, result.outcome) == (path, "failure")
    found = verify(path)
    assert found.verdict is Verdict.EQUIVALENT, found.reason
    (line,) = found.not_compared
    assert "tests.policy.recurrent.Recurrent" in line
    assert "not in the log" in line
    computed = sum(isinstance(message, Action | GroundControl) for message in open_log(path).messages())
    assert line.startswith(f"{computed} actions, not recomputed")
    assert not any("by the network" in line for line in found.checks)
    assert open_log(path).metadata["policy"] == "Recurrent"


def test_the_same_policy_gives_the_same_bytes(tmp_path: Path) -> None:
    assert flown(tmp_path / "a.mcap").log_sha256 == flown(tmp_path / "b.mcap").log_sha256


def test_an_altered_action_is_found_in_what_follows_from_it(tmp_path: Path) -> None:
    flown(tmp_path / "own.mcap")
    mission_file = MissionFile(parse_mission(SOURCE, "own.yaml"), SOURCE, tmp_path / "own.yaml")
    log = Flown(mission_file, Recurrent(), tmp_path / "own.mcap")
    messages = log.messages
    at = next(i for i, message in enumerate(messages) if isinstance(message, Action) and message.step == 50)
    messages[at] = altered(altered(messages[at], "commanded", 0, 40), "applied", 0, 40)
    found = verify(log.rewritten(tmp_path / "altered.mcap", messages))
    assert found.verdict is Verdict.DIVERGED
    assert found.first_divergence is not None
    assert (found.first_divergence.topic, found.first_divergence.step) == ("/reward", 50)


def test_a_flight_that_was_killed_is_not_gone_on_with(tmp_path: Path) -> None:
    flown(tmp_path / "own.mcap")
    part = tmp_path / "own.mcap.part"
    part.write_bytes((tmp_path / "own.mcap").read_bytes()[:-200])
    with pytest.raises(LogError, match=r"policy, tests.*not in the log"), unfinished(part):
        pass


def test_one_for_another_robot_is_refused(tmp_path: Path) -> None:
    class Dog(Recurrent):
        robot = "dog"

    with pytest.raises(PolicyError, match="made for the robot 'dog', not 'ant'"):
        flown(tmp_path / "own.mcap", policy=Dog())
