"""Protobuf's wire format, read without a schema: https://protobuf.dev/programming-guides/encoding.

What two parsers could read in two ways is refused: a field that may be there once and is doubled, a number or a text of
another wire type, a field's number of more than 32 bits.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, TypeAlias

MOST_FIELDS: Final = 200_000  # of a file
MOST_INTEGERS: Final = 64  # of a list

_VARINT: Final = 0
_DELIMITED: Final = 2
_FIXED_SIZES: Final = {1: 8, 5: 4}  # wire type: bytes

# A number, what is delimited (a message, text, packed numbers), or a number of fixed size, such as a float.
Value: TypeAlias = int | memoryview | bytes
Fields: TypeAlias = dict[int, list[Value]]


class Refused(ValueError):
    """A file has forbidden content; the text follows "the model has"."""


class Reader:
    """Reads the messages of one file and counts their fields."""

    def __init__(self) -> None:
        """Begin to count."""
        self._left = MOST_FIELDS

    def messages(self, fields: Fields, field: int) -> Iterator[Fields]:
        """Yield the messages that a repeated field holds."""
        for value in fields.get(field, []):
            if not isinstance(value, memoryview):
                raise ValueError(f"field {field} is not a message")
            yield self.fields(value)

    def fields(self, content: memoryview) -> Fields:
        """Return the values of a message by their fields' numbers."""
        found: Fields = {}
        at = 0
        while at < len(content):
            self._left -= 1
            if self._left < 0:
                raise Refused(f"more than {MOST_FIELDS:,} parts")
            tag, at = _varint(content, at)
            number, wire_type = tag >> 3, tag & 7
            if not number or tag >= 2**32:  # other parsers use the lower half
                raise ValueError(f"no field at byte {at}")
            if wire_type == _VARINT:
                value, at = _varint(content, at)
                found.setdefault(number, []).append(value)
                continue
            if wire_type == _DELIMITED:
                size, at = _varint(content, at)
            elif wire_type in _FIXED_SIZES:
                size = _FIXED_SIZES[wire_type]
            else:
                raise ValueError(f"wire type {wire_type} at byte {at}")
            if at + size > len(content):
                raise ValueError(f"field {number} ends {at + size - len(content)} bytes after its message")
            part = content[at : at + size]
            found.setdefault(number, []).append(part if wire_type == _DELIMITED else bytes(part))
            at += size
        return found


def one(fields: Fields, field: int) -> memoryview | None:
    """Return the bytes of a field that may be there once; None if it is not."""
    values = fields.get(field, [])
    if not values:
        return None
    if len(values) > 1 or not isinstance(values[0], memoryview):
        raise ValueError(f"field {field} occurs {len(values)} times, or is a number")
    return values[0]


def number(fields: Fields, field: int) -> int:
    """Return a number that may be there once; 0 if it is not."""
    values = fields.get(field, [0])
    if len(values) > 1 or not isinstance(values[0], int):
        raise ValueError(f"field {field} occurs {len(values)} times, or is not a number")
    return values[0]


def text(fields: Fields, field: int) -> str:
    """Return a text that may be there once; nothing if it is not."""
    value = one(fields, field)
    return "" if value is None else bytes(value).decode()


def texts(fields: Fields, field: int) -> tuple[str, ...]:
    """Return the texts of a repeated field."""
    values = fields.get(field, [])
    if not all(isinstance(value, memoryview) for value in values):
        raise ValueError(f"field {field} is not text")
    return tuple(bytes(value).decode() for value in values if isinstance(value, memoryview))


def integers(fields: Fields, field: int) -> tuple[int, ...]:
    """Return a repeated field of whole numbers, packed or one by one."""
    found: list[int] = []
    for value in fields.get(field, []):
        if isinstance(value, int):
            found.append(signed(value))
            continue
        if isinstance(value, bytes):
            raise ValueError(f"field {field} is not whole numbers")
        at = 0
        while at < len(value) and len(found) <= MOST_INTEGERS:
            each, at = _varint(value, at)
            found.append(signed(each))
    if len(found) > MOST_INTEGERS:
        raise Refused(f"a list of more than {MOST_INTEGERS} whole numbers")
    return tuple(found)


def signed(value: int) -> int:
    """Return a number of 64 bits with its sign."""
    return value - 2**64 if value >= 2**63 else value


def _varint(content: memoryview, at: int) -> tuple[int, int]:
    value = shift = 0
    while at < len(content) and shift < 64:
        byte = content[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value & (2**64 - 1), at
        shift += 7
    raise ValueError(f"no whole number at byte {at}")
