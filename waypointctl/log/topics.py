"""The topics of a flight's own records: which message stands on which, in which schema, at what times.

The topics for viewers (/tf, /scene, ...) are in foxglove/view.py; nothing is read back from them.
/camera is for both: its schema is a viewer's, and its messages come back.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from google.protobuf.message import Message as ProtobufMessage

from waypointctl.log import decode, encode, steps
from waypointctl.log.messages import (
    Ack,
    Action,
    Checkpoint,
    Command,
    CommandStage,
    ConsoleInput,
    Event,
    GroundControl,
    LinkRecord,
    Message,
    Observation,
    Picture,
    Reward,
    State,
    Telemetry,
)
from waypointctl.log.proto import messages_pb2 as pb


@dataclass(frozen=True, slots=True)
class Topic:
    """How one kind of message is kept."""

    name: str
    kind: type[Message]
    schema: type[ProtobufMessage]
    encode: Callable[[Any], bytes]
    decode: Callable[[bytes], Message]
    times_ns: Callable[[Any], tuple[int, int]]  # (log_time, publish_time)


def _instant(
    message: State
    | Observation
    | Action
    | Reward
    | CommandStage
    | GroundControl
    | LinkRecord
    | ConsoleInput
    | Event
    | Picture
    | Checkpoint,
) -> tuple[int, int]:
    return message.time_ns, message.time_ns


def _link(message: Command | Ack | Telemetry) -> tuple[int, int]:
    return message.received_ns, message.issued_ns


TOPICS: Final = (
    Topic("/state", State, pb.State, steps.state, decode.state, _instant),
    Topic("/observation", Observation, pb.Observation, steps.observation, decode.observation, _instant),
    Topic("/action", Action, pb.Action, steps.action, decode.action, _instant),
    Topic("/reward", Reward, pb.Reward, steps.reward, decode.reward, _instant),
    Topic("/command", Command, pb.Command, encode.command, decode.command, _link),
    Topic("/command_stage", CommandStage, pb.CommandStage, encode.command_stage, decode.command_stage, _instant),
    Topic("/ack", Ack, pb.Ack, encode.ack, decode.ack, _link),
    Topic("/telemetry", Telemetry, pb.Telemetry, encode.telemetry, decode.telemetry, _link),
    Topic("/ground_control", GroundControl, pb.GroundControl, encode.ground_control, decode.ground_control, _instant),
    Topic("/link", LinkRecord, pb.LinkRecord, encode.link_record, decode.link_record, _instant),
    Topic("/console", ConsoleInput, pb.ConsoleInput, encode.console_input, decode.console_input, _instant),
    Topic("/event", Event, pb.Event, encode.event, decode.event, _instant),
    Topic("/checkpoint", Checkpoint, pb.Checkpoint, encode.checkpoint, decode.checkpoint, _instant),
    Topic("/camera", Picture, CompressedImage, encode.picture, decode.picture, _instant),
)
ON_DEMAND: Final = frozenset({Picture})  # their topics are in a log only where it has such a message
BY_KIND: Final = {topic.kind: topic for topic in TOPICS}
BY_NAME: Final = {topic.name: topic for topic in TOPICS}
