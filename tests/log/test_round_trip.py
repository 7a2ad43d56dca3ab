"""Whatever is written comes back equal, to the last bit."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.log.fake_flight import bits, header
from waypointctl.log.messages import (
    Ack,
    Action,
    Checkpoint,
    Clock,
    Command,
    CommandKind,
    CommandStage,
    ConsoleInput,
    DeliveryOutcome,
    Event,
    EventKind,
    GroundControl,
    LinkRecord,
    Message,
    Mode,
    Observation,
    Picture,
    PlannedWaypoint,
    Reward,
    Severity,
    Stage,
    State,
    Telemetry,
)
from waypointctl.log.reader import open_log
from waypointctl.log.topics import BY_KIND
from waypointctl.log.writer import LogWriter

times = st.integers(0, 2**62)
whole = st.integers(-(2**63), 2**63 - 1)
floats = st.floats(width=64)  # NaN, infinities, -0.0 and subnormals too
vectors = arrays(np.float64, st.integers(0, 40), elements=floats)
names = st.text(max_size=20)
waypoints = st.builds(PlannedWaypoint, whole, names, floats, floats, names, floats, whole, whole)

BY_TYPE: dict[type, st.SearchStrategy[Message]] = {
    State: st.builds(State, times, whole, vectors, vectors, vectors),
    Observation: st.builds(Observation, times, whole, vectors),
    Action: st.builds(Action, times, whole, st.sampled_from(("policy", "stance", "off")), vectors, vectors),
    Reward: st.builds(Reward, times, whole, st.lists(st.tuples(names, floats), max_size=8).map(tuple), floats),
    Command: st.builds(
        Command, whole, st.sampled_from(CommandKind), st.lists(waypoints, max_size=4).map(tuple), names, times, times
    ),
    CommandStage: st.builds(CommandStage, times, whole, st.sampled_from(Stage), names, st.sampled_from(Clock), whole),
    GroundControl: st.builds(GroundControl, times, whole, times, vectors, vectors),
    LinkRecord: st.builds(
        LinkRecord,
        times,
        names,
        names,
        whole,
        whole,
        whole,
        st.lists(whole, max_size=3).map(tuple),
        st.sampled_from(DeliveryOutcome),
    ),
    Ack: st.builds(Ack, whole, st.sampled_from(Stage), names, times, times),
    Telemetry: st.builds(
        Telemetry,
        whole,
        st.sampled_from(Mode),
        *[floats] * 5,
        whole,
        st.lists(whole, max_size=5).map(tuple),
        times,
        times,
    ),
    ConsoleInput: st.builds(ConsoleInput, times, names),
    Event: st.builds(
        Event,
        times,
        st.sampled_from(EventKind),
        st.sampled_from(Clock),
        st.sampled_from(Severity),
        names,
        whole,
        whole,
    ),
    Picture: st.builds(Picture, times, names, names, st.binary(max_size=400)),
    Checkpoint: st.builds(Checkpoint, times, whole, vectors, names, names),
}


def test_every_message_type_is_tried() -> None:
    assert set(BY_TYPE) == set(get_args(Message)) == set(BY_KIND)


@pytest.mark.parametrize("kind", BY_TYPE, ids=lambda kind: kind.__name__)
@given(data=st.data())
def test_codec_gives_back_what_it_was_given(kind: type, data: st.DataObject) -> None:
    message = data.draw(BY_TYPE[kind])
    topic = BY_KIND[kind]
    assert bits(topic.decode(topic.encode(message))) == bits(message)


# The viewers' topics need states of the right size, so a file is tried with everything but State.
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(st.one_of(*[given for kind, given in BY_TYPE.items() if kind is not State]), max_size=12))
def test_a_file_gives_back_what_it_was_given(messages: list[Message]) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "flight.mcap"
        with LogWriter(path, header()) as sink:
            for message in messages:
                sink(message)
        assert [bits(message) for message in open_log(path).messages()] == [bits(message) for message in messages]


def test_arrays_come_back_writable_and_float64(tmp_path: Path) -> None:
    state = State(0, 0, np.zeros(9), np.zeros(8), np.zeros(8))
    topic = BY_KIND[State]
    back = topic.decode(topic.encode(state))
    assert isinstance(back, State)
    assert back.qpos.dtype == np.float64
    assert back.qpos.flags.writeable
