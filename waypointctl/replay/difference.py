"""Whether two records are the same, bit for bit, and where they part."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import fields
from typing import Any

import numpy as np

from waypointctl.log.messages import FloatArray, Message, PlannedWaypoint


def difference(logged: Message, replayed: Message) -> tuple[str, str, str] | None:
    """Return the first component in which two records differ with both values as text, or None.

    Floats are compared as bits: -0.0 is not 0.0, and a NaN is the same NaN.
    """
    if type(logged) is not type(replayed):
        return "type", type(logged).__name__, type(replayed).__name__
    for field in fields(logged):
        pairs = _pairs(field.name, getattr(logged, field.name), getattr(replayed, field.name))
        for component, a, b in pairs:
            return component, _text(a), _text(b)
    return None


def different_bits(a: FloatArray, b: FloatArray) -> list[int]:
    """Return where two arrays (n,) differ in their bits."""
    return [int(at) for at in np.flatnonzero(a.view(np.uint64) != b.view(np.uint64))]


def bits_of(value: float) -> int:
    """Return the 64 bits of a float."""
    return int(struct.unpack("<Q", struct.pack("<d", value))[0])


def _pairs(name: str, logged: Any, replayed: Any) -> Iterator[tuple[str, Any, Any]]:
    """Yield the components called `name` in which the two values differ, the first one first."""
    if isinstance(logged, np.ndarray):
        yield from _array_pairs(name, logged, replayed)
    elif isinstance(logged, float):
        if bits_of(logged) != bits_of(replayed):
            yield name, logged, replayed
    elif isinstance(logged, tuple) and isinstance(replayed, tuple) and len(logged) == len(replayed):
        for index, (a, b) in enumerate(zip(logged, replayed, strict=True)):
            yield from _pairs(f"{name}[{index}]", a, b)
    elif isinstance(logged, PlannedWaypoint) and isinstance(replayed, PlannedWaypoint):
        for field in fields(logged):
            yield from _pairs(f"{name}.{field.name}", getattr(logged, field.name), getattr(replayed, field.name))
    elif logged != replayed:
        yield name, logged, replayed


def _array_pairs(name: str, logged: FloatArray, replayed: FloatArray) -> Iterator[tuple[str, Any, Any]]:
    if logged.shape != replayed.shape:
        yield f"{name}.shape", logged.shape, replayed.shape
        return
    for at in different_bits(logged, replayed):
        yield f"{name}[{at}]", float(logged[at]), float(replayed[at])


def _text(value: Any) -> str:
    return f"{value!r} (0x{bits_of(value):016x})" if isinstance(value, float) else str(value)
