"""An ONNX model's bytes as records, read before anything runs them.

Flying needs neither the onnx package nor its protobuf classes. Numbers of fields:
https://github.com/onnx/onnx/blob/main/onnx/onnx.proto.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.policy.protobuf_fields import (
    MOST_INTEGERS,
    Fields,
    Reader,
    Refused,
    integers,
    number,
    one,
    signed,
    text,
    texts,
)

FLOAT: Final = 1
INT64: Final = 7
BOOL: Final = 9
# Bytes of a number of each element type that is read; 6 is int32, 10 float16, 11 float64.
ITEM_BYTES: Final = MappingProxyType({FLOAT: 4, 6: 4, INT64: 8, BOOL: 1, 10: 2, 11: 8})

_ATTRIBUTE_TYPES: Final = {2: 1, 3: 2, 4: 3, 5: 4, 7: 6, 8: 7, 9: 8}  # field that holds a value: number of its type
Integers: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Tensor:
    """A constant tensor.

    Attributes:
        name: of the tensor.
        shape: of its numbers.
        type: the number of its element type.
        known: its numbers, where they are few and int64.
        content: its numbers' bytes, where they are float32 and in one piece.
    """

    name: str
    shape: tuple[int, ...]
    type: int = FLOAT
    known: Integers | None = None
    content: bytes | memoryview = b""


@dataclass(frozen=True, slots=True)
class Node:
    """An operator's use. An attribute of floats is a tensor without its numbers; a list of texts is left out."""

    operator: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    attributes: Mapping[str, int | tuple[int, ...] | bytes | Tensor]


@dataclass(frozen=True, slots=True)
class Port:
    """An input or output: its element type's number, and its sizes, a name or nothing where they may be any."""

    name: str
    type: int
    shape: tuple[int | str | None, ...] | None


@dataclass(frozen=True, slots=True)
class Graph:
    """The graph of a model."""

    nodes: tuple[Node, ...]
    constants: tuple[Tensor, ...]
    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]


def read_graph(model: bytes) -> Graph:
    """Return the graph of a model.

    Raises:
        Refused: it has more than one file of standard operators, or is larger than what is read.
        ValueError: the bytes are not such a protobuf message.
    """
    reader = Reader()
    fields = reader.fields(memoryview(model))
    if 20 in fields or 25 in fields:
        raise Refused("functions or training steps of its own")
    for opset in reader.messages(fields, 8):
        _refuse_foreign(text(opset, 1))
    graph = reader.fields(one(fields, 7) or memoryview(b""))
    if 15 in graph:
        raise Refused("a sparse tensor")
    constants = tuple(_tensor(each) for each in reader.messages(graph, 5))
    names = {each.name for each in constants}  # old models also list them as inputs
    ports = [_port(reader, each) for each in reader.messages(graph, 11)]
    return Graph(
        tuple(_node(reader, each) for each in reader.messages(graph, 1)),
        constants,
        tuple(port for port in ports if port.name not in names),
        tuple(_port(reader, each) for each in reader.messages(graph, 12)),
    )


def _node(reader: Reader, fields: Fields) -> Node:
    _refuse_foreign(text(fields, 7))
    attributes: dict[str, int | tuple[int, ...] | bytes | Tensor] = {}
    for attribute in reader.messages(fields, 5):
        if attribute.keys() & {6, 11}:
            raise Refused("a graph within a graph")
        held = attribute.keys() & _ATTRIBUTE_TYPES.keys()
        if attribute.keys() & {10, 15, 14, 21, 22, 23} or len(held) > 1:
            raise Refused("an attribute of a kind that is not read")
        name, value = text(attribute, 1), _attribute(reader, attribute)
        if name in attributes or any(number(attribute, 20) != _ATTRIBUTE_TYPES[field] for field in held):
            raise ValueError(f"the attribute {name[:40]!r} occurs twice, or has another type than declared")
        if value is not None:
            attributes[name] = value
    return Node(text(fields, 4), texts(fields, 1), texts(fields, 2), attributes)


def _attribute(reader: Reader, fields: Fields) -> int | tuple[int, ...] | bytes | Tensor | None:
    if 5 in fields:
        return _tensor(reader.fields(one(fields, 5) or memoryview(b"")))
    if 8 in fields:
        return integers(fields, 8)
    if floats := fields.get(7):
        count = sum(len(value) // 4 if isinstance(value, memoryview) else 1 for value in floats)
        return Tensor("", (count,))
    if 2 in fields:
        return Tensor("", ())
    if 4 in fields:
        return bytes(one(fields, 4) or b"")
    return signed(number(fields, 3)) if 3 in fields else None


def _tensor(fields: Fields) -> Tensor:
    if 13 in fields or number(fields, 14):
        raise Refused("a tensor kept in another file")
    shape, kind = integers(fields, 1), number(fields, 2)
    if kind not in ITEM_BYTES:
        raise Refused("a tensor of numbers that are not float, int32, int64 or bool")
    held = [
        len(value) for number in (4, 5, 7, 9, 10) for value in fields.get(number, []) if isinstance(value, memoryview)
    ]
    single = sum(len(fields.get(number, [])) for number in (4, 5, 7, 10))
    size = math.prod(shape) if all(side >= 0 for side in shape) else -1
    # Each number takes a byte at least, wherever it is held; raw ones take all of theirs.
    if not 0 <= size <= sum(held) + single or (9 in fields and size * ITEM_BYTES[kind] != sum(held)):
        raise Refused(f"a tensor of shape {list(shape)} without its numbers")
    known = _known(fields, shape, size) if kind == INT64 else None
    pieces = [*fields.get(9, []), *fields.get(4, [])] if kind == FLOAT else []
    content = next((each for each in pieces if isinstance(each, memoryview)), b"")
    return Tensor(text(fields, 8), shape, kind, known, content)


def _known(fields: Fields, shape: tuple[int, ...], size: int) -> Integers | None:
    if size > MOST_INTEGERS:
        return None
    raw = one(fields, 9)
    numbers = np.array(integers(fields, 7), np.int64) if raw is None else np.frombuffer(raw, "<i8")
    if numbers.size != size:
        raise ValueError(f"a tensor of shape {shape} has {numbers.size} numbers")
    return numbers.reshape(shape)


def _port(reader: Reader, fields: Fields) -> Port:
    tensor = reader.fields(one(reader.fields(one(fields, 2) or memoryview(b"")), 1) or memoryview(b""))
    shape = one(tensor, 2)
    sides = None if shape is None else tuple(map(_side, reader.messages(reader.fields(shape), 1)))
    return Port(text(fields, 1), number(tensor, 1), sides)


def _side(fields: Fields) -> int | str | None:
    return signed(number(fields, 1)) if 1 in fields else text(fields, 2) or None


def _refuse_foreign(domain: str) -> None:
    if domain not in ("", "ai.onnx"):
        raise Refused(f"operators of the domain {domain[:80]!r}")
