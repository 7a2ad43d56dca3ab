"""Whatever is changed in a log, however little, is found where it is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.replay.rewriting import Flown, altered, bit_flipped, step_under_way
from waypointctl.flight import header
from waypointctl.log.comparison import Divergence
from waypointctl.log.messages import (
    Ack,
    Action,
    Checkpoint,
    Command,
    Event,
    EventKind,
    Message,
    Observation,
    Reward,
    State,
    Telemetry,
)
from waypointctl.replay import contents
from waypointctl.replay.verify import Verdict, verify


def nth(messages: list[Message], number: int, of: type[Any], /, **wanted: object) -> int:
    """Return the index of the number-th message of a kind whose fields are as wanted; -1 is the last."""
    found = [
        i
        for i, message in enumerate(messages)
        if isinstance(message, of) and all(getattr(message, key) == value for key, value in wanted.items())
    ]
    return found[number]


def divergence(flown: Flown, out: Path, messages: list[Message]) -> Divergence:
    found = verify(flown.rewritten(out / "altered.mcap", messages))
    assert found.verdict is Verdict.DIVERGED
    assert found.first_divergence is not None
    assert found.first_divergence.component in found.reason
    return found.first_divergence


FLIPS = [
    (State, 0, "qpos", 7, 0),
    (State, 30, "qpos", 0, 0),
    (State, 31, "qpos", 3, 51),
    (State, 40, "qvel", 13, 0),
    (State, 12, "qacc_warmstart", 5, 0),
    (State, -1, "qpos", 14, 0),
    (State, 20, "qvel", 0, 63),
    (Observation, 0, "values", 0, 0),
    (Observation, -1, "values", 30, 0),
    (Action, 2, "commanded", 3, 0),
    (Action, 2, "applied", 3, 0),
    (Action, 25, "commanded", 0, 0),
    (Action, 25, "applied", 0, 0),
    (Action, 26, "commanded", 7, 63),
    (Action, -1, "applied", 7, 0),
    (Checkpoint, 0, "integration", 0, 0),
    (Checkpoint, 0, "integration", 20, 0),
]


@pytest.mark.parametrize(("kind", "number", "field", "index", "bit"), FLIPS)
def test_one_flipped_bit_is_found_at_its_step_topic_and_component(
    flown: Flown, tmp_path: Path, kind: type[Any], number: int, field: str, index: int, bit: int
) -> None:
    messages = flown.messages
    at = nth(messages, number, kind)
    original: Any = messages[at]
    messages[at] = altered(original, field, index, bit)
    found = divergence(flown, tmp_path, messages)
    assert (found.step, found.component) == (original.step, f"{field}[{index}]")
    assert found.topic == f"/{kind.__name__.lower()}"
    assert found.time_ns == original.time_ns
    assert repr(float(getattr(original, field)[index])) in found.replayed
    assert repr(float(getattr(messages[at], field)[index])) in found.logged


NUMBERS = [
    (State, 9, "time_ns"),
    (State, 9, "step"),
    (Reward, 30, "total"),
    (Reward, 30, "time_ns"),
    (Command, 0, "received_ns"),
    (Command, 1, "issued_ns"),
    (Command, 1, "id"),
    (Command, 0, "waypoints"),
    (Command, 2, "on_failure"),
    (Ack, 0, "received_ns"),
    (Ack, 4, "issued_ns"),
    (Ack, -1, "command_id"),
    (Ack, 3, "reason"),
    (Telemetry, 3, "received_ns"),
    (Telemetry, 4, "issued_ns"),
    (Telemetry, 4, "frame"),
    (Telemetry, 2, "x_m"),
    (Telemetry, 2, "heading_rad"),
    (Telemetry, 2, "speed_mps"),
    (Telemetry, -1, "target"),
    (Telemetry, -1, "reached"),
    (Event, 0, "time_ns"),
    (Event, 5, "time_ns"),
    (Event, 5, "text"),
    (Event, 5, "waypoint"),
    (Event, -1, "command_id"),
    (Checkpoint, 0, "executive"),
    (Checkpoint, 0, "link"),
]


@pytest.mark.parametrize(("kind", "number", "field"), NUMBERS)
def test_one_changed_value_is_found_at_its_step_topic_and_component(
    flown: Flown, tmp_path: Path, kind: type[Any], number: int, field: str
) -> None:
    messages = flown.messages
    at = nth(messages, number, kind)
    expected_step = step_under_way(messages, at)
    messages[at] = altered(messages[at], field)
    found = divergence(flown, tmp_path, messages)
    assert (found.step, found.topic, found.component) == (expected_step, f"/{kind.__name__.lower()}", field)


def test_another_source_of_an_action_is_found(flown: Flown, tmp_path: Path) -> None:
    messages = flown.messages
    at = nth(messages, 9, Action)
    action: Any = messages[at]
    messages[at] = replace(action, source="off")
    found = divergence(flown, tmp_path, messages)
    assert (found.step, found.topic, found.component, found.logged) == (9, "/action", "source", "off")


@pytest.mark.parametrize("term", range(8))
def test_one_flipped_bit_in_a_reward_term_is_found(flown: Flown, tmp_path: Path, term: int) -> None:
    messages = flown.messages
    at = nth(messages, 33, Reward)
    reward: Any = messages[at]
    name, value = reward.terms[term]
    terms = [*reward.terms]
    terms[term] = (name, bit_flipped(value))
    messages[at] = Reward(reward.time_ns, reward.step, tuple(terms), reward.total)
    found = divergence(flown, tmp_path, messages)
    assert (found.step, found.topic, found.component) == (reward.step, "/reward", f"terms[{term}][1]")


def test_an_event_of_another_kind_is_found(flown: Flown, tmp_path: Path) -> None:
    messages = flown.messages
    at = nth(messages, 0, Event, kind=EventKind.WAYPOINT_REACHED)
    event: Any = messages[at]
    messages[at] = Event(
        event.time_ns, EventKind.WAYPOINT_TIMEOUT, event.clock, event.severity, event.text, event.waypoint
    )
    assert divergence(flown, tmp_path, messages).component == "kind"


KINDS = [State, Observation, Action, Reward, Command, Ack, Telemetry, Event, Checkpoint]


@pytest.mark.parametrize("kind", KINDS)
def test_a_message_that_is_missing_is_found(flown: Flown, tmp_path: Path, kind: type[Any]) -> None:
    messages = flown.messages
    at = nth(messages, 0, kind)
    step = step_under_way(messages, at - 1) if kind is not State else 0
    del messages[at]
    assert divergence(flown, tmp_path, messages).step == step


@pytest.mark.parametrize("kind", KINDS)
def test_a_message_too_many_is_found(flown: Flown, tmp_path: Path, kind: type[Any]) -> None:
    messages = flown.messages
    at = nth(messages, -1, kind)
    messages.insert(at, messages[at])
    found = divergence(flown, tmp_path, messages)
    assert found.topic == f"/{kind.__name__.lower()}"


def test_two_messages_in_the_wrong_order_are_found(flown: Flown, tmp_path: Path) -> None:
    messages = flown.messages
    at = nth(messages, 10, Action)
    messages[at], messages[at + 1] = messages[at + 1], messages[at]
    found = divergence(flown, tmp_path, messages)
    assert (found.step, found.component, found.logged, found.replayed) == (10, "type", "Reward", "Action")


def test_a_log_that_goes_on_after_the_flight_is_found(flown: Flown, tmp_path: Path) -> None:
    messages = flown.messages
    found = divergence(flown, tmp_path, [*messages, messages[-1]])
    assert (found.topic, found.component, found.logged) == ("/event", "end", "Event")


@pytest.mark.parametrize("kept", [0, 1, 200])
def test_a_log_that_ends_before_the_flight_is_found(flown: Flown, tmp_path: Path, kept: int) -> None:
    messages = flown.messages
    found = divergence(flown, tmp_path, messages[:kept])
    assert (found.component, found.logged, found.replayed) == ("end", "the log ends", "the flight continues")
    assert found.step == step_under_way(messages, kept)


class TestOnAnotherProcessor:
    """Where the network may round otherwise, the logged actions drive the physics and the network is held near."""

    @pytest.fixture(autouse=True)
    def _elsewhere(self, monkeypatch: pytest.MonkeyPatch) -> None:
        here = dict(header.platform_facts()) | {"processor": "another one"}
        monkeypatch.setattr(contents, "platform_facts", lambda: here)

    def test_physics_and_messages_are_still_the_same_and_the_file_but_for_what_names_the_processor(
        self, flown: Flown
    ) -> None:
        found = verify(flown.path)
        assert found.verdict is Verdict.EQUIVALENT
        assert "byte for byte" in found.checks[-1]
        (line,) = found.not_compared
        assert line.startswith("the program and processor named in the log: the processor was ")
        assert line.endswith(" and is another one")

    @pytest.mark.parametrize(("bit", "verdict"), [(3, Verdict.UNVERIFIABLE), (25, Verdict.DIVERGED)])
    def test_an_action_changed_by_rounding_is_not_what_led_to_the_state_that_follows(
        self, flown: Flown, tmp_path: Path, bit: int, verdict: Verdict
    ) -> None:
        messages = flown.messages
        at = nth(messages, 20, Action, source="policy")
        action: Any = messages[at]
        joint = next(i for i in range(8) if 1e-3 < abs(action.commanded[i]) < 1)
        messages[at] = altered(altered(action, "commanded", joint, bit), "applied", joint, bit)
        found = verify(flown.rewritten(tmp_path / "altered.mcap", messages))
        assert found.verdict is verdict
        assert verdict is Verdict.DIVERGED or "the processor was" in found.reason
        assert found.first_divergence is not None
        assert found.first_divergence.topic in ("/reward", "/state")
        assert found.first_divergence.step in (action.step, action.step + 1)

    @pytest.mark.parametrize(
        ("kind", "field", "bit"), [(Observation, "values", 40), (Telemetry, "x_m", 40), (Action, "commanded", 48)]
    )
    def test_more_than_rounding_diverges(
        self, flown: Flown, tmp_path: Path, kind: type[Any], field: str, bit: int
    ) -> None:
        messages = flown.messages
        at = nth(messages, 20 if kind is not Telemetry else 2, kind)
        messages[at] = altered(messages[at], field, 0, bit)
        assert divergence(flown, tmp_path, messages).component.startswith(field)

    @pytest.mark.parametrize(("kind", "field"), [(Observation, "values"), (Telemetry, "x_m")])
    def test_rounding_makes_it_approximate_and_is_counted(
        self, flown: Flown, tmp_path: Path, kind: type[Any], field: str
    ) -> None:
        messages = flown.messages
        at = nth(messages, 20 if kind is Observation else 2, kind)
        messages[at] = altered(messages[at], field, 0, 3)
        found = verify(flown.rewritten(tmp_path / "altered.mcap", messages))
        assert found.verdict is Verdict.APPROXIMATE
        what = "observation" if kind is Observation else "telemetry frame"
        assert found.not_compared[0] == f"1 {what}: equal within 1e-12, not bit for bit"

    def test_another_action_than_the_networks_diverges_at_once(self, flown: Flown, tmp_path: Path) -> None:
        messages = flown.messages
        at = nth(messages, 20, Action, source="policy")
        action: Any = messages[at]
        messages[at] = altered(action, "commanded", 2, 50)
        found = divergence(flown, tmp_path, messages)
        assert (found.topic, found.step, found.component) == ("/action", action.step, "commanded[2]")
