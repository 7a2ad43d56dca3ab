"""Every message of every small link, held against a link worked out event by event."""

from __future__ import annotations

import json
import sys
from collections import Counter
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.ops.link.slow_link import Gate, Parcel, SlowLink
from waypointctl.ops.link.contacts import Contacts, Window
from waypointctl.ops.link.delay import Jitter, fixed_delay, table_delay, uniform_jitter
from waypointctl.ops.link.direction import NEVER, NO_CONTACT, NOISE, QUEUE_FULL, Direction, Doubling, Fate
from waypointctl.ops.link.draws import BLOCK, Draws
from waypointctl.ops.link.loss import GilbertElliott, RandomLoss
from waypointctl.seeding import stream

ROUNDS = 60  # of windows that come again, in the oracle; more than any example needs


class Told:
    """Decides what it is told, in place of chance."""

    def __init__(self, values: list[bool]) -> None:
        self._values = iter(values)

    def __call__(self) -> bool:
        return next(self._values)

    def state(self) -> dict[str, object]:
        return {}

    def restore(self, state: object) -> None:
        raise NotImplementedError


def arrival(number: int, when: int) -> tuple[int, int]:
    return when, number


def following(number: int, _: int) -> int:
    return number + 1


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
        doubling=Doubling(
            Told([parcel.copies == 2 for parcel in sent]), told_jitter([parcel.jitters[1] for parcel in sent])
        ),
        contacts=Contacts(setting.windows, setting.period),
        queue_bytes=setting.room,
    )


@given(settings_of_a_link(), parcels())
@settings(max_examples=150, deadline=None)
def test_each_message_fares_as_it_does_event_by_event(setting: Setting, sent: list[Parcel]) -> None:
    slow = SlowLink(setting.gates(), setting.room, setting.delay, setting.ordered)
    slow.run(sent)
    link = told_direction(setting, sent)
    for parcel in sent:
        fate = link.send(parcel.at, parcel.size, partial(arrival, parcel.number))
        if parcel.number in slow.refused:
            assert fate == Fate(NEVER, NEVER, (), slow.refused[parcel.number])
            continue
        assert (fate.departs_ns, fate.left_ns) == slow.departed[parcel.number]
        assert fate.lost == (NOISE if parcel.number in slow.lost else "")
        assert list(fate.arrivals_ns) == [when for when, number in slow.arrived if number == parcel.number]
    assert list(link.due(1 << 60)) == slow.arrived


@given(settings_of_a_link(), parcels(), st.integers(1, 50))
@settings(max_examples=60, deadline=None)
def test_bytes_are_conserved_at_every_moment(setting: Setting, sent: list[Parcel], tick: int) -> None:
    """Handed over = refused + lost on the way + waiting + being sent or under way + delivered."""
    link = told_direction(setting, sent)
    fates: dict[int, Fate] = {}
    delivered: Counter[int] = Counter()
    coming = list(sent)
    for now in range(0, sent[-1].at + 600, tick):
        while coming and coming[0].at <= now:
            parcel = coming.pop(0)
            fates[parcel.number] = link.send(parcel.at, parcel.size, partial(arrival, parcel.number))
        for when, number in link.due(now):
            assert now - tick < when <= now or fates[number].left_ns <= when, "neither early nor forgotten"
            delivered[number] += 1
        handed = [parcel for parcel in sent if parcel.number in fates]
        waiting = sum(parcel.size for parcel in handed if fates[parcel.number].departs_ns > now)
        assert link.waiting_bytes(now) == waiting <= setting.room
        under_way = Counter(number for _, (_, number) in link.under_way)
        for parcel in handed:
            expected = 0 if fates[parcel.number].lost else parcel.copies
            assert delivered[parcel.number] + under_way[parcel.number] == expected
    for gate in setting.gates():
        inside = [
            parcel.size
            for parcel in sent
            if fates[parcel.number].departs_ns != NEVER and gate.begin <= fates[parcel.number].departs_ns < gate.end
        ]
        if gate.rate is not None:
            assert sum(inside) * 8e9 <= gate.rate * (gate.end - gate.begin)


@given(settings_of_a_link(), parcels(), st.integers(0, 25))
@settings(max_examples=50, deadline=None)
def test_a_restored_link_goes_on_as_the_one_it_was_taken_from(setting: Setting, sent: list[Parcel], cut: int) -> None:
    def fresh() -> Direction[int]:
        return Direction(
            delay=fixed_delay(setting.delay),
            jitter=uniform_jitter(50, stream(1, "jitter")),
            keeps_order=setting.ordered,
            loss=GilbertElliott(0.3, 0.4, 0.9, 0.1, stream(1, "loss")),
            doubling=Doubling(RandomLoss(0.3, stream(1, "double")), uniform_jitter(50, stream(1, "second"))),
            contacts=Contacts(setting.windows, setting.period),
            queue_bytes=setting.room,
        )

    link, other = fresh(), fresh()
    for parcel in sent[:cut]:
        list(link.due(parcel.at))
        link.send(parcel.at, parcel.size, lambda when: when)
    other.restore(json.loads(json.dumps(link.state())), link.under_way)
    for parcel in sent[cut:]:
        assert link.send(parcel.at, parcel.size, lambda when: when) == other.send(
            parcel.at, parcel.size, lambda when: when
        )
        assert list(link.due(parcel.at)) == list(other.due(parcel.at))
    assert list(link.due(1 << 60)) == list(other.due(1 << 60))
    assert link.state() == other.state()


def luck(link: Direction[int], sizes: list[int], gap: int) -> list[tuple[int, str]]:
    """Return of each message how long it was under way after it had left, and why it was lost on the way if it was."""
    fates = [link.send(gap * number, size, lambda when: when) for number, size in enumerate(sizes)]
    return [(fate.arrivals_ns[0] - fate.left_ns if fate.arrivals_ns else -1, fate.lost) for fate in fates]


def chancy(seed: int, *, losing: float = 0.1, **changes: object) -> Direction[int]:
    plain = Direction[int](
        delay=fixed_delay(10_000),
        jitter=uniform_jitter(5_000, stream(seed, "jitter")),
        keeps_order=False,
        loss=RandomLoss(losing, stream(seed, "loss")),
        contacts=Contacts([Window(0, 1 << 60, 8e9)]),
    )
    return replace(plain, **changes)  # type: ignore[arg-type]


@given(st.lists(st.integers(1, 3000), min_size=600, max_size=600), st.integers(0, 5))
@settings(max_examples=10, deadline=None)
def test_no_message_shifts_another_ones_luck_by_its_size(sizes: list[int], seed: int) -> None:
    assert luck(chancy(seed), sizes, 3000) == luck(chancy(seed), [1] * 600, 3000)


def test_no_message_shifts_another_ones_luck_by_being_lost_or_refused() -> None:
    sizes = [700] * 600
    all_arrive = luck(chancy(3, losing=0.0), sizes, 1000)
    some_lost = luck(chancy(3, losing=0.3), sizes, 1000)
    refused = luck(chancy(3, losing=0.3, queue_bytes=0), [2000 if n % 7 == 0 else 700 for n in range(600)], 1000)
    assert 120 < sum(bool(lost) for _, lost in some_lost) < 240
    assert sum(lost == QUEUE_FULL for _, lost in refused) > 60
    for kept, lossy, tight in zip(all_arrive, some_lost, refused, strict=True):
        assert lossy in (kept, (-1, NOISE))
        assert tight in (lossy, (-1, QUEUE_FULL))


def test_the_same_seed_is_the_same_trace_and_another_seed_another() -> None:
    sizes = list(range(1, 700))
    assert luck(chancy(1), sizes, 500) == luck(chancy(1), sizes, 500) != luck(chancy(2), sizes, 500)


def test_a_doubled_message_that_is_lost_arrives_once() -> None:
    link = Direction[int](loss=Told([True, False, True]), doubling=Doubling(Told([True, True, False])))
    assert [len(link.send(0, 1, lambda when: when).arrivals_ns) for _ in range(3)] == [1, 2, 0]


def test_nothing_overtakes_where_the_delay_falls_faster_than_time_goes_by() -> None:
    falling = table_delay([(0, 1000), (100, 0)])
    sent = [Direction[int](delay=falling, keeps_order=ordered) for ordered in (True, False)]
    arrivals = [[link.send(at, 1, lambda when: when).arrivals_ns[0] for at in range(0, 101, 10)] for link in sent]
    assert arrivals[0] == [1000] * 11
    assert arrivals[1] == [1000 - 9 * at for at in range(0, 101, 10)]
    assert [list(link.due(1000)) for link in sent] == [arrivals[0], sorted(arrivals[1])]


def test_a_message_larger_than_the_queue_goes_when_it_need_not_wait() -> None:
    link = Direction[int](contacts=Contacts([Window(0, 1 << 40, 8e9)]), queue_bytes=10)
    first, second, third = (link.send(at, 100, lambda when: when) for at in (0, 99, 100))
    assert (first.left_ns, second.lost, third.departs_ns) == (100, QUEUE_FULL, 100)


def test_a_message_larger_than_every_contact_blocks_nothing() -> None:
    link = Direction[int](contacts=Contacts([Window(0, 50, 8e9)], 100))
    assert link.send(0, 51, lambda when: when).lost == NO_CONTACT
    assert link.send(0, 50, lambda when: when).left_ns == 50
    assert link.send(0, 50, lambda when: when).departs_ns == 100


def test_what_is_sent_while_the_mail_is_read_is_read_too() -> None:
    link = Direction[int]()
    link.send(0, 1, lambda _: 0)
    numbers = []
    for number in link.due(0):
        numbers.append(number)
        if number < 3:
            link.send(0, 1, partial(following, number))
    assert numbers == [0, 1, 2, 3]


def test_the_latest_arrival_counts_queue_contact_delay_and_jitter() -> None:
    link = chancy(0, losing=0.0, contacts=Contacts([Window(100, 1000, 8e9)], 5000))
    assert link.latest_arrival_ns(0, 10) == 100 + 10 + 10_000 + 5_000
    link.send(0, 850, lambda when: when)
    assert link.latest_arrival_ns(0, 10) == 100 + 850 + 10 + 10_000 + 5_000
    assert link.latest_arrival_ns(0, 60) == 5100 + 60 + 10_000 + 5_000
    assert link.latest_arrival_ns(0, 901) is None
    assert [link.send(0, 10, lambda when: when).departs_ns for _ in range(2)] == [950, 960], "asking changed nothing"


def test_five_days_of_delay_cost_no_more_work_than_none() -> None:
    def calls(delay_ns: int) -> int:
        link = chancy(5, losing=0.05, delay=fixed_delay(delay_ns))
        count = 0

        def note(frame: object, event: str, argument: object) -> None:
            nonlocal count
            count += event in ("call", "c_call")

        sys.setprofile(note)
        try:
            for number in range(4 * BLOCK):
                link.send(1000 * number, 100, lambda when: when)
            for _ in link.due(1 << 60):
                pass
        finally:
            sys.setprofile(None)
        return count

    assert calls(5 * 86_400 * 10**9) <= calls(0)
