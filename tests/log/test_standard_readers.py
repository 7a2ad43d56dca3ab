"""Readers that know nothing of waypointctl read every message, by the schemas that the log carries."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.log.fake_flight import flight
from waypointctl.log.messages import Command, Message, Reward, State, Telemetry

READ_WITH_MCAP_ALONE = """
import json, sys
from google.protobuf.json_format import MessageToDict
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

found = {}
with open(sys.argv[1], "rb") as stream:
    reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
    for schema, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
        assert type(decoded).DESCRIPTOR.full_name == schema.name
        found.setdefault(channel.topic, []).append(MessageToDict(decoded, preserving_proto_field_name=True))
assert not [name for name in sys.modules if name.split(".")[0] in ("waypointctl", "foxglove_schemas_protobuf")]
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def decoded(log_path: Path) -> dict[str, list[dict[str, object]]]:
    command = [sys.executable, "-c", READ_WITH_MCAP_ALONE, str(log_path)]
    done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=log_path.parent)
    found: dict[str, list[dict[str, object]]] = json.loads(done.stdout)
    return found


def sent(kind: type[Message]) -> list[Message]:
    return [message for message in flight() if isinstance(message, kind)]


def test_every_topic_decodes(decoded: dict[str, list[dict[str, object]]]) -> None:
    assert len(decoded) == 16


def test_states_are_arrays_of_numbers(decoded: dict[str, list[dict[str, object]]]) -> None:
    for read, state in zip(decoded["/state"], sent(State), strict=True):
        assert isinstance(state, State)
        assert read["qpos"] == state.qpos.tolist()
        assert int(str(read.get("time_ns", 0))) == state.time_ns


def test_rewards_are_named_terms_and_their_sum(decoded: dict[str, list[dict[str, object]]]) -> None:
    for read, reward in zip(decoded["/reward"], sent(Reward), strict=True):
        assert isinstance(reward, Reward)
        assert read["terms"] == [{"name": name, "value": value} for name, value in reward.terms]
        assert read["total"] == reward.total


def test_words_are_words_and_delays_can_be_plotted(decoded: dict[str, list[dict[str, object]]]) -> None:
    [command] = decoded["/command"]
    assert command["kind"] == "upload_plan"
    assert command["delay_s"] == 1.28
    assert len(sent(Command)) == 1
    assert {(frame["mode"], frame["delay_s"]) for frame in decoded["/telemetry"]} == {("navigating", 1.29)}
    assert len(decoded["/telemetry"]) == len(sent(Telemetry))
