"""The logged flight as the comparator of its replay: each message is compared as it is made again."""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import Any, Final

import numpy as np

from waypointctl.log.comparison import Diverged, Divergence
from waypointctl.log.messages import FloatArray, GroundControl, Message, Observation, PlannedWaypoint, State, Telemetry
from waypointctl.log.reader import EncodedMessage
from waypointctl.log.records import shown


class LogEnded(Exception):
    """The log holds no more: it was cut short."""


class LogComparator:
    """Takes the replay's messages, with the logged ones to hold them against.

    What is computed with numpy's trigonometry, observations and telemetry, may be rounded otherwise on another
    processor. States never may: physics continues from them.

    Most messages are the same bytes as those of the log, which is seen without decoding them.

    Attributes:
        compared: how many messages of each topic were found equal.
        rounded: how many of them only within rounding.
    """

    def __init__(self, logged: Iterator[EncodedMessage], *, bitwise: bool) -> None:
        """Take the logged messages in their order; without `bitwise` let numpy round otherwise."""
        self._logged = logged
        self._rounded = () if bitwise else (Observation, Telemetry, GroundControl)
        self._next = next(logged, None)
        self._opened: Message | None = None  # the next one, once it has been read
        self._step = 0
        self._time_ns = 0
        self.compared: Counter[str] = Counter()
        self.rounded: Counter[str] = Counter()

    def __call__(self, replayed: Message) -> Message:
        """Compare a message of the replay with the next one of the log, and return that one."""
        if isinstance(replayed, State):
            self._step, self._time_ns = replayed.step, replayed.time_ns
        sealed = self._next
        if sealed is None:
            raise LogEnded
        logged = replayed if sealed.matches(replayed) else self._equal(sealed, replayed)
        self.compared[sealed.topic.name] += 1
        self._next, self._opened = next(self._logged, None), None
        return logged

    @property
    def has_ended(self) -> bool:
        """Whether every message of the log has been compared."""
        return self._next is None

    @property
    def upcoming_kind(self) -> type[Message] | None:
        """What kind of message comes next in the log."""
        return None if self._next is None else self._next.topic.kind

    @property
    def upcoming(self) -> Message | None:
        """The next message of the log, not yet compared."""
        if self._opened is None and self._next is not None:
            self._opened = self._next.message()
        return self._opened

    @property
    def step(self) -> int:
        """The control step under way."""
        return self._step

    def _equal(self, sealed: EncodedMessage, replayed: Message) -> Message:
        logged, topic = sealed.message(), sealed.topic.name
        found = difference(logged, replayed)
        if found is not None:
            if found.rounding and isinstance(replayed, self._rounded):
                found = difference(logged, replayed, rounded=True)
                self.rounded[topic] += 1
            if found is not None:
                raise self.diverged(topic, found.component, found.logged, found.replayed, rounding=found.rounding)
        return logged

    def diverged(self, topic: str, component: str, logged: str, replayed: str, *, rounding: bool = False) -> Diverged:
        """Return the error for a divergence at this place."""
        where = Divergence(self._step, self._time_ns, topic, component, logged, replayed)
        return Diverged(where, rounding=rounding)


EXCERPT: Final = 60  # characters shown on either side of where long texts part
ROUNDING: Final = 1e-12  # absolute, and relative above 1; numpy's trigonometry differs by 1e-15 between processors


@dataclass(frozen=True, slots=True)
class Difference:
    """The first difference between two records."""

    component: str  # the field, with an index where it has many
    logged: str  # the value in the log, as text; a float with its bits
    replayed: str  # the value in the replay
    rounding: bool  # whether the values are as near as two ways of rounding may leave them


def difference(logged: Message, replayed: Message, *, rounded: bool = False) -> Difference | None:
    """Return the first component in which two records differ, or None.

    Floats are compared as bits: -0.0 is not 0.0, and a NaN is the same NaN. With `rounded` those that are as near
    as two ways of rounding may leave them are taken as the same.
    """
    if type(logged) is not type(replayed):
        return Difference("type", type(logged).__name__, type(replayed).__name__, rounding=False)
    for field in fields(logged):
        for component, a, b in _pairs(field.name, getattr(logged, field.name), getattr(replayed, field.name)):
            near = _near(a, b)
            if not (rounded and near):
                return Difference(component, *_texts(a, b), near)
    return None


def _near(a: Any, b: Any) -> bool:
    return isinstance(a, float) and isinstance(b, float) and abs(a - b) <= ROUNDING * max(1.0, abs(a))


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


def _texts(logged: Any, replayed: Any) -> tuple[str, str]:
    a, b = _text(logged), _text(replayed)
    if max(len(a), len(b)) <= 2 * EXCERPT:
        return a, b
    same = next((at for at, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), min(len(a), len(b)))
    begin = max(0, same - EXCERPT)
    return f"...{a[begin : same + EXCERPT]}...", f"...{b[begin : same + EXCERPT]}..."


def _text(value: Any) -> str:
    if isinstance(value, bytes):
        return shown(value)
    return f"{value!r} (0x{bits_of(value):016x})" if isinstance(value, float) else str(value)
