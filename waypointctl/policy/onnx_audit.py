"""Read an ONNX model's bytes for what a policy must not contain, before anything runs them.

onnxruntime would look up operators of foreign domains and follow tensors into other files; a policy is one
file of standard operators. The wire format is walked here, so that flying needs neither the onnx package nor
its protobuf classes. Field numbers: https://github.com/onnx/onnx/blob/main/onnx/onnx.proto,
wire format: https://protobuf.dev/programming-guides/encoding.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, NamedTuple

STANDARD_DOMAINS: Final = ("", "ai.onnx")

# message -> {field number: the message it holds}; all other fields are values.
_MESSAGES: Final[dict[str, dict[int, str]]] = {
    "model": {7: "graph", 8: "opset", 20: "training", 25: "function"},
    "training": {1: "graph", 2: "graph"},
    "graph": {1: "node", 5: "tensor", 15: "sparse"},
    "function": {7: "node", 9: "opset", 11: "attribute"},
    "node": {5: "attribute"},
    "attribute": {5: "tensor", 6: "graph", 10: "tensor", 11: "graph", 22: "sparse", 23: "sparse"},
    "sparse": {1: "tensor", 2: "tensor"},
}
_DOMAIN_FIELDS: Final = {("opset", 1), ("node", 7), ("function", 10)}
_EXTERNAL_FIELDS: Final = {("tensor", 13), ("tensor", 14)}  # external_data, data_location (0 is inside the model)
_FIXED_SIZES: Final = {1: 8, 5: 4}  # wire type: bytes
_VARINT: Final = 0
_DELIMITED: Final = 2


class _Field(NamedTuple):
    number: int
    value: int | memoryview


def unsafe_parts(model: bytes) -> list[str]:
    """Return what in an ONNX model a policy must not contain, in words; empty if there is nothing.

    Raises:
        ValueError: the bytes are not a protobuf message.
    """
    found: dict[str, None] = {}  # an ordered set
    pending = [("model", memoryview(model))]
    while pending:
        message, content = pending.pop()
        for number, value in _fields(content):
            inner = _MESSAGES.get(message, {}).get(number)
            if inner is not None and isinstance(value, memoryview):
                pending.append((inner, value))
            elif (message, number) in _EXTERNAL_FIELDS and value:
                found["a tensor kept in another file"] = None
            elif (message, number) in _DOMAIN_FIELDS and isinstance(value, memoryview):
                domain = bytes(value).decode(errors="replace")
                if domain not in STANDARD_DOMAINS:
                    found[f"operators of the domain {domain!r}"] = None
    return list(found)


def _fields(content: memoryview) -> Iterator[_Field]:
    at = 0
    while at < len(content):
        tag, at = _varint(content, at)
        number, wire_type = tag >> 3, tag & 7
        if wire_type == _VARINT:
            value, at = _varint(content, at)
            yield _Field(number, value)
            continue
        if wire_type == _DELIMITED:
            size, at = _varint(content, at)
        elif wire_type in _FIXED_SIZES:
            size = _FIXED_SIZES[wire_type]
        else:
            raise ValueError(f"wire type {wire_type} at byte {at}")
        if at + size > len(content):
            raise ValueError(f"field {number} ends {at + size - len(content)} bytes after its message")
        yield _Field(number, content[at : at + size])
        at += size


def _varint(content: memoryview, at: int) -> tuple[int, int]:
    value = shift = 0
    while at < len(content) and shift < 64:
        byte = content[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, at
        shift += 7
    raise ValueError(f"no whole number at byte {at}")
