"""The topics of a flight's own records: which message stands on which, in which schema, at what times, in which bytes.

Each field of a record is the protobuf field of its name, equal to the last bit; steps.py encodes the messages of every
control step. A word outside its enumeration raises ValueError; bytes that are not such a message raise
google.protobuf.message.DecodeError. The reader adds their place.

The topics for viewers (/tf, /scene, ...) are in foxglove/view.py; nothing is read back from them.
/camera is for both: its schema is a viewer's, and its messages come back.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from enum import StrEnum
from typing import Any, Final, TypeAlias, get_args, get_origin, get_type_hints

import numpy as np
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from google.protobuf.message import Message as ProtobufMessage

from waypointctl.log import steps
from waypointctl.log.foxglove.motion import timestamp
from waypointctl.log.messages import (
    Ack,
    Action,
    Checkpoint,
    Command,
    CommandStage,
    CommandStatus,
    ConsoleInput,
    Event,
    FloatArray,
    GroundControl,
    LinkRecord,
    Message,
    Observation,
    Picture,
    PlannedWaypoint,
    Reward,
    State,
    Telemetry,
)
from waypointctl.log.proto import messages_pb2 as pb
from waypointctl.units import NS_PER_S, seconds

Convert: TypeAlias = Callable[[Any], Any] | None  # None: as it is

_PARTS: Final = {PlannedWaypoint: pb.PlannedWaypoint, CommandStatus: pb.Telemetry.CommandStatus}
_DELAY: Final = "delay_s"  # repeats for viewers what two times say
_SOURCES: Final = ("policy", "ground", "stance", "off")  # of an action


def encoder(kind: type, schema: type[ProtobufMessage]) -> Callable[[Any], bytes]:
    """Return what encodes records of a kind."""
    build = _builder(kind, schema)

    def encode(message: Any) -> bytes:
        data: bytes = build(message).SerializeToString()
        return data

    return encode


def decoder(kind: type, schema: type[ProtobufMessage]) -> Callable[[bytes], Any]:
    """Return what decodes records of a kind."""
    read = _reader(kind)
    return lambda data: read(schema.FromString(data))


def _builder(kind: type, schema: type[ProtobufMessage]) -> Callable[[Any], Any]:
    """Return what makes a protobuf message of a record."""
    parts = [(name, _to_protobuf(hint)) for name, hint in _fields(kind)]
    has_delay = _DELAY in schema.DESCRIPTOR.fields_by_name

    def build(record: Any) -> Any:
        values = {
            name: getattr(record, name) if convert is None else convert(getattr(record, name))
            for name, convert in parts
        }
        return schema(**values, delay_s=_delay_s(record)) if has_delay else schema(**values)

    return build


def _reader(kind: type) -> Callable[[Any], Any]:
    """Return what makes a record of a protobuf message."""
    parts = [(name, _from_protobuf(hint)) for name, hint in _fields(kind)]

    def read(it: Any) -> Any:
        return kind(*[getattr(it, name) if convert is None else convert(getattr(it, name)) for name, convert in parts])

    return read


def _fields(kind: type) -> list[tuple[str, Any]]:
    hints = get_type_hints(kind)
    return [(field.name, hints[field.name]) for field in fields(kind)]


def _to_protobuf(hint: Any) -> Convert:
    if hint == FloatArray:
        return np.ndarray.tolist
    (of, *_) = get_args(hint) or (None,)
    if of in _PARTS:
        build = _builder(of, _PARTS[of])
        return lambda records: [build(record) for record in records]
    return None


def _from_protobuf(hint: Any) -> Convert:
    if hint == FloatArray:
        return array
    if isinstance(hint, type) and issubclass(hint, StrEnum):
        return hint
    if get_origin(hint) is not tuple:
        return None
    of = get_args(hint)[0]
    if of not in _PARTS:
        return tuple
    read = _reader(of)
    return lambda messages: tuple([read(it) for it in messages])


def _delay_s(record: Any) -> float:
    if isinstance(record, LinkRecord):
        return seconds(record.arrives_ns[0] - record.time_ns) if record.arrives_ns else 0.0
    return seconds(record.received_ns - record.issued_ns)


def array(values: Sequence[float]) -> FloatArray:
    """Return an array (n,) of a repeated field."""
    # A slice is a plain list, which numpy reads twice as fast as protobuf's container.
    return np.array(values[:], dtype=np.float64)


def decode_action(data: bytes) -> Action:
    """Decode an Action."""
    it = pb.Action.FromString(data)
    if it.source not in _SOURCES:
        raise ValueError(f"{it.source!r} is not a source of an action; allowed: {', '.join(_SOURCES)}")
    return Action(it.time_ns, it.step, it.source, array(it.commanded), array(it.applied))


def decode_reward(data: bytes) -> Reward:
    """Decode a Reward."""
    it = pb.Reward.FromString(data)
    return Reward(it.time_ns, it.step, tuple([(term.name, term.value) for term in it.terms]), it.total)


def encode_picture(message: Picture) -> bytes:
    """Encode a Picture, in a viewer's schema."""
    data: bytes = CompressedImage(
        timestamp=timestamp(message.time_ns), frame_id=message.frame_id, data=message.data, format=message.format
    ).SerializeToString()
    return data


def decode_picture(data: bytes) -> Picture:
    """Decode a Picture."""
    it = CompressedImage.FromString(data)
    time_ns = it.timestamp.seconds * NS_PER_S + it.timestamp.nanos
    return Picture(time_ns, it.frame_id, it.format, it.data)


@dataclass(frozen=True, slots=True)
class Topic:
    """How one kind of message is kept."""

    name: str
    kind: type[Message]
    schema: type[ProtobufMessage]
    encode: Callable[[Any], bytes]
    decode: Callable[[bytes], Message]
    times_ns: Callable[[Any], tuple[int, int]]  # (log_time, publish_time)


def _instant(message: Any) -> tuple[int, int]:
    return message.time_ns, message.time_ns


def _link(message: Command | Ack | Telemetry) -> tuple[int, int]:
    return message.received_ns, message.issued_ns


def _topic(
    name: str,
    kind: type[Message],
    schema: type[ProtobufMessage],
    times_ns: Callable[[Any], tuple[int, int]] = _instant,
    *,
    encode: Callable[[Any], bytes] | None = None,
    decode: Callable[[bytes], Message] | None = None,
) -> Topic:
    return Topic(name, kind, schema, encode or encoder(kind, schema), decode or decoder(kind, schema), times_ns)


TOPICS: Final = (
    _topic("/state", State, pb.State, encode=steps.state),
    _topic("/observation", Observation, pb.Observation, encode=steps.observation),
    _topic("/action", Action, pb.Action, encode=steps.action, decode=decode_action),
    _topic("/reward", Reward, pb.Reward, encode=steps.reward, decode=decode_reward),
    _topic("/command", Command, pb.Command, _link),
    _topic("/command_stage", CommandStage, pb.CommandStage),
    _topic("/ack", Ack, pb.Ack, _link),
    _topic("/telemetry", Telemetry, pb.Telemetry, _link),
    _topic("/ground_control", GroundControl, pb.GroundControl),
    _topic("/link", LinkRecord, pb.LinkRecord),
    _topic("/console", ConsoleInput, pb.ConsoleInput),
    _topic("/event", Event, pb.Event),
    _topic("/checkpoint", Checkpoint, pb.Checkpoint),
    _topic("/camera", Picture, CompressedImage, encode=encode_picture, decode=decode_picture),
)
ON_DEMAND: Final = frozenset({Picture})  # their topics are in a log only where it has such a message
BY_KIND: Final = {topic.kind: topic for topic in TOPICS}
BY_NAME: Final = {topic.name: topic for topic in TOPICS}
