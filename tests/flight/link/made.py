"""Links for tests: without chance, held to be told what becomes of each message, or with a little of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

from tests.flight.link.slow_link import Gate, Parcel
from waypointctl.flight.link.contacts import Contacts, Window
from waypointctl.flight.link.direction import Direction, Duplication
from waypointctl.flight.link.impairments import Draws, Jitter, RandomLoss, fixed_delay, uniform_jitter
from waypointctl.seeding import stream

ROUNDS = 60  # of windows that come again, in the oracle; more than any example needs


class Told:
    """Decides what it is told, in place of chance."""

    loses_all = False

    def __init__(self, values: list[bool]) -> None:
        self._values = iter(values)

    def __call__(self) -> bool:
        return next(self._values)

    def state(self) -> dict[str, Any]:
        return {}


def arrival(number: int, when: int) -> tuple[int, int]:
    return when, number


def told_jitter(values: list[int]) -> Jitter:
    it = iter(values)
    return Jitter(Draws(np.random.default_rng(0), lambda _, count: [next(it, 0) for _ in range(count)]), 0)


@dataclass(frozen=True)
class Setting:
    """A link without chance, for both."""

    windows: tuple[Window, ...]
    period: int
    room: int
    delay: int
    ordered: bool

    def gates(self) -> list[Gate]:
        rounds = range(ROUNDS if self.period else 1)
        return [
            Gate(each.begin_ns + k * self.period, each.end_ns + k * self.period, each.rate_bps)
            for k in rounds
            for each in self.windows
        ]


# Rates at which a byte takes 1 ns, 2.67 ns, 8 ns, 1/3 ns; and no rate at all.
RATES = st.sampled_from([8e9, 3e9, 1e9, 24e9, None])


@st.composite
def settings_of_a_link(draw: st.DrawFn) -> Setting:
    windows, at = [], 0
    for _ in range(draw(st.integers(1, 4))):
        begin = at + draw(st.integers(0, 60))
        at = begin + draw(st.integers(1, 120))
        windows.append(Window(begin, at, draw(RATES)))
    period = at + draw(st.integers(0, 40)) if draw(st.booleans()) else 0
    if not period and draw(st.booleans()):
        windows.append(Window(at, 1 << 50, draw(RATES)))
    room = draw(st.sampled_from([0, 5, 20, 50, 1 << 20]))
    return Setting(tuple(windows), period, room, draw(st.integers(0, 200)), draw(st.booleans()))


@st.composite
def parcels(draw: st.DrawFn) -> list[Parcel]:
    at, made = 0, []
    for number in range(draw(st.integers(1, 25))):
        at += draw(st.sampled_from([0, 0, 1, 3, 10, 40]))
        jitters = (draw(st.integers(-80, 80)), draw(st.integers(-80, 80)))
        made.append(Parcel(number, at, draw(st.integers(1, 40)), draw(st.sampled_from([1, 1, 1, 0, 2])), jitters))
    return made


def told_direction(setting: Setting, sent: list[Parcel]) -> Direction[tuple[int, int]]:
    """Return the link under test, chance replaced by what the parcels say."""
    return Direction(
        delay=fixed_delay(setting.delay),
        jitter=told_jitter([parcel.jitters[0] for parcel in sent]),
        keeps_order=setting.ordered,
        loss=Told([parcel.copies == 0 for parcel in sent]),
        duplication=Duplication(
            Told([parcel.copies == 2 for parcel in sent]), told_jitter([parcel.jitters[1] for parcel in sent])
        ),
        contacts=Contacts(setting.windows, setting.period),
        queue_bytes=setting.room,
    )


def chancy(seed: int, *, losing: float = 0.1, **changes: object) -> Direction[int]:
    plain = Direction[int](
        delay=fixed_delay(10_000),
        jitter=uniform_jitter(5_000, stream(seed, "jitter")),
        keeps_order=False,
        loss=RandomLoss(losing, stream(seed, "loss")),
        contacts=Contacts([Window(0, 1 << 60, 8e9)]),
    )
    return replace(plain, **changes)  # type: ignore[arg-type]
