"""What replay says of logs that were altered to hold what no flight could: never a traceback, always the summary."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.flying import Program
from tests.replay.rewriting import Flown, fly_once
from waypointctl.cli.flight_view import json_text
from waypointctl.flight.header import MISSION
from waypointctl.log.messages import Action, Command, Message, Reward, State, Telemetry
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.flight_log import FlightLog
from waypointctl.replay.picture.page import draw
from waypointctl.replay.summary import summary_json

Alter = Callable[[Any], Any]


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Flown:
    """A flight whose log is to be written again."""
    folder = tmp_path_factory.mktemp("flight")
    return fly_once(folder, make_policy(folder / "policy", seed=7))


def altered(messages: list[Message], of: type[Any], alter: Alter, number: int = 3) -> list[Message]:
    """Return the messages with one of a kind altered; its times are left as they are."""
    at = [index for index, message in enumerate(messages) if isinstance(message, of)][number]
    return [*messages[:at], alter(messages[at]), *messages[at + 1 :]]


def with_entry(field: str, index: int, value: float) -> Alter:
    def alter(message: Any) -> Any:
        values = getattr(message, field).copy()
        values[index] = value
        return replace(message, **{field: values})

    return alter


def with_first_waypoint(**changed: float) -> Alter:
    def alter(command: Command) -> Command:
        return replace(command, waypoints=(replace(command.waypoints[0], **changed), *command.waypoints[1:]))  # type: ignore[arg-type]

    return alter


def with_nan_term(reward: Reward) -> Reward:
    (name, _), *rest = reward.terms
    return replace(reward, terms=((name, math.nan), *rest))


def refuse_constant(word: str) -> None:
    raise AssertionError(f"{word} is no JSON")


# What is altered, and what the summary then says that it leaves out of sums and drawings.
ALTERED = {
    "qpos nan": (State, with_entry("qpos", 0, math.nan), "1 state"),
    "qpos inf": (State, with_entry("qpos", 1, -math.inf), "1 state"),
    "qpos huge": (State, with_entry("qpos", 0, 1e300), "1 state"),
    "qvel huge": (State, with_entry("qvel", 1, -1.7e308), "1 state"),
    "qpos short": (State, lambda state: replace(state, qpos=state.qpos[:1]), "1 state"),
    "qvel empty": (State, lambda state: replace(state, qvel=np.zeros(0)), "1 state"),
    "height nan": (State, with_entry("qpos", 2, math.nan), None),
    "frame nan": (Telemetry, lambda frame: replace(frame, x_m=math.nan), "1 telemetry frame"),
    "frame huge": (Telemetry, lambda frame: replace(frame, y_m=1e300), "1 telemetry frame"),
    "frame far": (Telemetry, lambda frame: replace(frame, x_m=9e5), None),
    "reward nan": (Reward, lambda reward: replace(reward, total=math.nan), None),
    "reward huge": (Reward, lambda reward: replace(reward, total=1e300), None),
    "term nan": (Reward, with_nan_term, None),
    "applied nan": (Action, with_entry("applied", 0, math.nan), None),
    "commanded nan": (Action, with_entry("commanded", 0, math.nan), None),
    "last time": (State, lambda state: replace(state, time_ns=(1 << 63) - 1), None),
}


@pytest.mark.parametrize(("of", "alter", "left_out"), ALTERED.values(), ids=ALTERED)
def test_an_altered_log_diverges_and_is_summed_up(
    flown: Flown, tmp_path: Path, program: Program, of: type[Any], alter: Alter, left_out: str | None
) -> None:
    log = flown.rewritten(tmp_path / "altered.mcap", altered(flown.messages, of, alter))
    code, out, err = program("replay", str(log))
    assert (code, err) == (1, "")
    assert out.startswith("DIVERGED: ")
    assert "success: 2 of 3 waypoints reached" in out
    said = f"left out   {left_out}: not finite, or beyond 1,000,000 m\n"
    assert said in out if left_out else "not finite" not in out
    summary = json.loads(
        json_text(summary_json(FlightLog.open(log).summary, "altered")), parse_constant=refuse_constant
    )
    assert (summary["states_off_map"], summary["frames_off_map"]) == (
        left_out == "1 state",
        left_out == "1 telemetry frame",
    )
    assert summary["distance_m"] < 100.0  # of a flight of seconds, in which one state was left out at most


@pytest.mark.parametrize("name", ["qpos huge", "frame nan"])
def test_an_altered_log_is_drawn(flown: Flown, tmp_path: Path, name: str) -> None:
    of, alter, _ = ALTERED[name]
    log = FlightLog.open(flown.rewritten(tmp_path / "altered.mcap", altered(flown.messages, of, alter)))
    picture = draw(log.summary, "altered", "diverged", is_exact=False)
    assert struct.unpack(">II", picture[16:24]) == (1600, 1000)


def test_a_replay_of_an_altered_log_is_json(flown: Flown, tmp_path: Path, program: Program) -> None:
    log = flown.rewritten(tmp_path / "altered.mcap", altered(flown.messages, State, ALTERED["qpos nan"][1]))
    code, out, _ = program("replay", str(log), "--json")
    found = json.loads(out, parse_constant=refuse_constant)
    assert (code, found["verdict"], found["summary"]["states_off_map"]) == (1, "diverged", 1)


def test_the_sum_of_a_reward_that_is_no_number_is_null(flown: Flown, tmp_path: Path, program: Program) -> None:
    log = flown.rewritten(tmp_path / "altered.mcap", altered(flown.messages, Reward, ALTERED["reward nan"][1]))
    assert json.loads(program("replay", str(log), "--json")[1])["summary"]["reward_total"] is None


@pytest.mark.parametrize("changed", [{"x_m": math.nan}, {"y_m": 1e300}, {"tolerance_m": math.inf}])
@pytest.mark.parametrize("carries_mission", [True, False])
def test_a_commanded_waypoint_that_is_nowhere(
    flown: Flown, tmp_path: Path, program: Program, changed: dict[str, float], carries_mission: bool
) -> None:
    messages = altered(flown.messages, Command, with_first_waypoint(**changed), 0)
    attachments = {} if carries_mission else {MISSION: b"name: of no use"}
    log = flown.rewritten(tmp_path / "altered.mcap", messages, attachments=attachments)
    code, out, err = program("replay", str(log))
    assert code == 1
    assert "DIVERGED: " in out + err
    # The mission's own waypoints are told of; only where there are none are the commanded ones.
    assert ("left out   1 waypoint: " in out + err) is not carries_mission


@pytest.mark.parametrize("option", ["--json", "--png"])
def test_a_waypoint_that_is_nowhere_is_left_out_of_json_and_pictures(
    flown: Flown, tmp_path: Path, program: Program, option: str
) -> None:
    messages = altered(flown.messages, Command, with_first_waypoint(y_m=1e300), 0)
    log = flown.rewritten(tmp_path / "altered.mcap", messages, attachments={MISSION: b"name: of no use"})
    code, out, err = program(
        "replay", str(log), option, *([str(tmp_path / "altered.png")] if option == "--png" else [])
    )
    assert code == 1
    assert "left out   1 waypoint: " in out + err


def test_a_flight_that_is_nowhere_at_all(flown: Flown, tmp_path: Path, program: Program) -> None:
    astray = with_entry("qpos", 0, math.nan)
    messages: list[Message] = [astray(each) if isinstance(each, State) else each for each in flown.messages]
    log = flown.rewritten(tmp_path / "altered.mcap", messages)
    code, out, _ = program("replay", str(log), "--png", str(tmp_path / "altered.png"))
    assert code == 1
    assert "distance   0.00 m" in out
    states = sum(isinstance(each, State) for each in messages)
    assert f"left out   {states} states: " in out


def test_an_action_of_an_unknown_source_is_damage(flown: Flown, tmp_path: Path, program: Program) -> None:
    messages = altered(flown.messages, Action, lambda action: replace(action, source="polixy"))
    log = flown.rewritten(tmp_path / "altered.mcap", messages)
    for options in ((), ("--verify",), ("--json",), ("--rate", "100")):
        code, out, err = program("replay", str(log), *options)
        assert (code, out.startswith('{"error": ')) == (2, options == ("--json",))
        assert "source of an action; allowed: policy, ground, stance, off" in err
        assert err.splitlines()[-2].startswith(f"error: {log}: is damaged at byte ")
