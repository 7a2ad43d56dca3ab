"""The messages of every control step to protobuf bytes, put together from pieces: the hot half of encode.py.

Protobuf concatenates: the bytes of a message are the bytes of its fields, one after the other. Arrays are the bulk of
these messages and stand in memory as protobuf writes them, so only what is around them is asked of protobuf, once.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

from waypointctl.log.messages import Action, FloatArray, Observation, Reward, State
from waypointctl.log.proto import messages_pb2 as pb
from waypointctl.log.template import NUMBER, Template

_LENGTH_DELIMITED: Final = 2  # protobuf's wire type of a packed array


def state(message: State) -> bytes:
    """Encode a State."""
    return (
        _step(message.time_ns, message.step)
        + doubles(pb.State.QPOS_FIELD_NUMBER, message.qpos)
        + doubles(pb.State.QVEL_FIELD_NUMBER, message.qvel)
        + doubles(pb.State.QACC_WARMSTART_FIELD_NUMBER, message.qacc_warmstart)
    )


def observation(message: Observation) -> bytes:
    """Encode an Observation."""
    return _step(message.time_ns, message.step) + doubles(pb.Observation.VALUES_FIELD_NUMBER, message.values)


def action(message: Action) -> bytes:
    """Encode an Action."""
    return (
        _step(message.time_ns, message.step)
        + _source(message.source)
        + doubles(pb.Action.COMMANDED_FIELD_NUMBER, message.commanded)
        + doubles(pb.Action.APPLIED_FIELD_NUMBER, message.applied)
    )


def reward(message: Reward) -> bytes:
    """Encode a Reward."""
    names, values = zip(*message.terms, strict=True) if message.terms else ((), ())
    return _step(message.time_ns, message.step) + _terms(names).pack((*values, message.total))


def doubles(field: int, values: FloatArray) -> bytes:
    """Encode an array (n,) as the packed repeated double field of that number."""
    if not values.size:
        return b""
    return _doubles_head(field, values.size) + values.astype("<f8", copy=False).tobytes()


@lru_cache(maxsize=16)
def _step(time_ns: int, step: int) -> bytes:
    # All four messages begin with these fields, and three of a step's with the same values.
    return pb.State(time_ns=time_ns, step=step).SerializeToString()


@lru_cache(maxsize=64)
def _doubles_head(field: int, count: int) -> bytes:
    return _varint(field << 3 | _LENGTH_DELIMITED) + _varint(8 * count)


@lru_cache(maxsize=16)
def _source(source: str) -> bytes:
    return pb.Action(source=source).SerializeToString()


@lru_cache(maxsize=16)
def _terms(names: tuple[str, ...]) -> Template:
    return Template(pb.Reward(terms=[pb.Reward.Term(name=name, value=NUMBER) for name in names], total=NUMBER))


def _varint(value: int) -> bytes:
    # Seven bits a byte, the lower first; all but the last are marked as not the last.
    low, rest = value & 127, value >> 7
    return bytes((low | 128,)) + _varint(rest) if rest else bytes((low,))
