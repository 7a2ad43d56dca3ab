from __future__ import annotations

import pytest

from tests.flight.flying import OUT_OF_REACH, STILL, TICK_NS, TUMBLE, UNDER_FOOT, Scripted, mission_of, only, times_ns
from tests.flight.scripted_lines import ScriptedLines
from tests.log.fake_flight import bits
from waypointctl.flight.fly import fly
from waypointctl.flight.outcome import FlightResult
from waypointctl.log.messages import (
    Ack,
    Command,
    CommandKind,
    ConsoleInput,
    Event,
    EventKind,
    Message,
    Stage,
    State,
)
from waypointctl.mission.mission import Mission
from waypointctl.units import NS_PER_S, ns


def flown(
    mission: Mission, console: ScriptedLines, policy: Scripted | None = None
) -> tuple[FlightResult, list[Message]]:
    messages: list[Message] = []
    return fly(mission, policy or Scripted(STILL), messages.append, console=console), messages


def test_a_line_is_sent_at_the_next_control_step_and_obeyed_one_delay_later() -> None:
    _, messages = flown(
        mission_of(UNDER_FOOT | {"hold_s": 5.0}, delay_ms=300), ScriptedLines((2.005, "goto 0.5 0.25"), (4.0, "quit"))
    )
    line, quit_line = only(ConsoleInput, messages)
    assert (line.time_ns, line.text, quit_line.text) == (2_020_000_000, "goto 0.5 0.25", "quit")
    went = next(command for command in only(Command, messages) if command.kind is CommandKind.GO_TO)
    assert (went.issued_ns, went.received_ns) == (line.time_ns, line.time_ns + 300_000_000)
    assert (went.waypoints[0].x_m, went.waypoints[0].y_m) == (0.5, 0.25)
    assert messages.index(line) < messages.index(went)


def test_every_word_becomes_its_command() -> None:
    said = {
        "goto 1 2": CommandKind.GO_TO,
        "hold": CommandKind.HOLD,
        "resume": CommandKind.RESUME,
        "skip": CommandKind.SKIP,
        "cancel 1": CommandKind.CANCEL,
        "release 1": CommandKind.RELEASE,
        "tolerance 0.5": CommandKind.SET_TOLERANCE,
        "timeout 20": CommandKind.SET_TIMEOUT,
        "home": CommandKind.RETURN_HOME,
        "abort": CommandKind.ABORT,
    }
    typed = [(0.1 * number, line) for number, line in enumerate(said, 1)]
    _, messages = flown(mission_of(UNDER_FOOT | {"hold_s": 9.0}), ScriptedLines(*typed, (3.0, "quit")))
    arrived = [command.kind for command in only(Command, messages) if command.id > 1]
    assert arrived == list(said.values())


def test_a_mission_that_is_done_waits_for_the_console() -> None:
    mission = mission_of(UNDER_FOOT, delay_ms=100)
    without = fly(mission, Scripted(STILL), lambda _: None)
    result, messages = flown(mission, ScriptedLines((5.0, "quit")))
    assert without.sim_time_ns < NS_PER_S
    assert (result.outcome, result.sim_time_ns) == ("success", 5 * NS_PER_S)
    assert times_ns(EventKind.CONSOLE_OPENED, messages) == [0]
    assert times_ns(EventKind.CONSOLE_CLOSED, messages) == [5 * NS_PER_S]


def test_a_console_that_closes_early_leaves_the_mission_alone() -> None:
    mission = mission_of(UNDER_FOOT | {"hold_s": 2.0}, UNDER_FOOT, delay_ms=100)
    result, messages = flown(mission, ScriptedLines((0.0, "quit")))
    plain: list[Message] = []
    assert fly(mission, Scripted(STILL), plain.append) == result
    console = (EventKind.CONSOLE_OPENED, EventKind.CONSOLE_CLOSED)
    rest = [
        bits(message)
        for message in messages
        if not isinstance(message, ConsoleInput) and not (isinstance(message, Event) and message.kind in console)
    ]
    assert rest == [bits(message) for message in plain]


def test_a_line_wakes_a_flight_that_sleeps_without_simulating_what_lies_between() -> None:
    mission = mission_of(UNDER_FOOT, delay_ms=100, telemetry={"rate_hz": 1.0, "beacon_s": 3600.0})
    _, messages = flown(mission, ScriptedLines((100.013, "hold"), (200.0, "quit")))
    assert [line.time_ns for line in only(ConsoleInput, messages)] == [100_020_000_000, 200 * NS_PER_S]
    held = next(command for command in only(Command, messages) if command.kind is CommandKind.HOLD)
    assert held.received_ns == 100_120_000_000
    states = only(State, messages)
    assert len(states) * TICK_NS < 60 * NS_PER_S, "physics slept for most of the 200 s"


def test_what_the_script_has_given_up_a_person_may_try_again() -> None:
    mission = mission_of(OUT_OF_REACH, delay_ms=100)
    result, messages = flown(mission, ScriptedLines((5.0, "goto 0.1 0"), (8.0, "quit")))
    assert result.outcome == "failure"
    (went,) = (command for command in only(Command, messages) if command.kind is CommandKind.GO_TO)
    stages = [ack.stage for ack in only(Ack, messages) if ack.command_id == went.id]
    assert Stage.STARTED in stages


def test_nobody_at_a_console_makes_a_fallen_robot_walk() -> None:
    result, messages = flown(mission_of(OUT_OF_REACH | {"timeout_s": 60.0}), ScriptedLines(), Scripted(TUMBLE))
    assert times_ns(EventKind.FALL, messages)
    assert result.outcome == "failure"
    assert "fall" in result.reason


@pytest.mark.parametrize("limit_s", [3.0])
def test_the_missions_time_ends_it_whoever_is_there(limit_s: float) -> None:
    mission = mission_of(UNDER_FOOT, expect={"max_time_s": limit_s})
    result, _ = flown(mission, ScriptedLines())
    assert result.outcome == "failure"
    assert result.sim_time_ns == ns(limit_s) + TICK_NS
