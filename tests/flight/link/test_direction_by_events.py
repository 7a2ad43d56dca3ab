"""Every message of every small link, held against a link worked out event by event."""

from __future__ import annotations

import json
from collections import Counter
from functools import partial

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.budget import examples
from tests.flight.link.made import Setting, arrival, parcels, settings_of_a_link, told_direction
from tests.flight.link.restored import restore
from tests.flight.link.slow_link import Parcel, SlowLink
from waypointctl.flight.link.contacts import Contacts
from waypointctl.flight.link.direction import NEVER, NOISE, Delivery, Direction, Duplication
from waypointctl.flight.link.impairments import GilbertElliott, RandomLoss, fixed_delay, uniform_jitter
from waypointctl.seeding import stream


@given(settings_of_a_link(), parcels())
@settings(max_examples=examples(400), deadline=None)
def test_each_message_fares_as_it_does_event_by_event(setting: Setting, sent: list[Parcel]) -> None:
    slow = SlowLink(setting.gates(), setting.room, setting.delay, setting.ordered)
    slow.run(sent)
    link = told_direction(setting, sent)
    for parcel in sent:
        delivery = link.send(parcel.at, parcel.size, partial(arrival, parcel.number))
        if parcel.number in slow.refused:
            assert delivery == Delivery(NEVER, NEVER, (), slow.refused[parcel.number])
            continue
        assert (delivery.departs_ns, delivery.left_ns) == slow.departed[parcel.number]
        assert delivery.lost == (NOISE if parcel.number in slow.lost else "")
        assert list(delivery.arrivals_ns) == [when for when, number in slow.arrived if number == parcel.number]
    assert list(link.due(1 << 60)) == slow.arrived


@given(settings_of_a_link(), parcels(), st.integers(1, 50))
@settings(max_examples=examples(150), deadline=None)
def test_bytes_are_conserved_at_every_moment(setting: Setting, sent: list[Parcel], tick: int) -> None:
    """Handed over = refused + lost on the way + waiting + being sent or under way + delivered."""
    link = told_direction(setting, sent)
    deliveries: dict[int, Delivery] = {}
    delivered: Counter[int] = Counter()
    coming = list(sent)
    for now in range(0, sent[-1].at + 600, tick):
        while coming and coming[0].at <= now:
            parcel = coming.pop(0)
            deliveries[parcel.number] = link.send(parcel.at, parcel.size, partial(arrival, parcel.number))
        for when, number in link.due(now):
            assert now - tick < when <= now or deliveries[number].left_ns <= when, "neither early nor forgotten"
            delivered[number] += 1
        handed = [parcel for parcel in sent if parcel.number in deliveries]
        waiting = sum(parcel.size for parcel in handed if deliveries[parcel.number].departs_ns > now)
        assert link.waiting_bytes(now) == waiting <= setting.room
        under_way = Counter(number for _, (_, number) in link.under_way)
        for parcel in handed:
            expected = 0 if deliveries[parcel.number].lost else parcel.copies
            assert delivered[parcel.number] + under_way[parcel.number] == expected
    for gate in setting.gates():
        inside = [
            parcel.size
            for parcel in sent
            if deliveries[parcel.number].departs_ns != NEVER
            and gate.begin <= deliveries[parcel.number].departs_ns < gate.end
        ]
        if gate.rate is not None:
            assert sum(inside) * 8e9 <= gate.rate * (gate.end - gate.begin)


@given(settings_of_a_link(), parcels(), st.integers(0, 25))
@settings(max_examples=examples(50), deadline=None)
def test_a_restored_link_goes_on_as_the_one_it_was_taken_from(setting: Setting, sent: list[Parcel], cut: int) -> None:
    def fresh() -> Direction[int]:
        return Direction(
            delay=fixed_delay(setting.delay),
            jitter=uniform_jitter(50, stream(1, "jitter")),
            keeps_order=setting.ordered,
            loss=GilbertElliott(0.3, 0.4, 0.9, 0.1, stream(1, "loss")),
            duplication=Duplication(RandomLoss(0.3, stream(1, "double")), uniform_jitter(50, stream(1, "second"))),
            contacts=Contacts(setting.windows, setting.period),
            queue_bytes=setting.room,
        )

    link, other = fresh(), fresh()
    for parcel in sent[:cut]:
        list(link.due(parcel.at))
        link.send(parcel.at, parcel.size, lambda when: when)
    restore(other, json.loads(json.dumps(link.state())), link.under_way)
    for parcel in sent[cut:]:
        assert link.send(parcel.at, parcel.size, lambda when: when) == other.send(
            parcel.at, parcel.size, lambda when: when
        )
        assert list(link.due(parcel.at)) == list(other.due(parcel.at))
    assert list(link.due(1 << 60)) == list(other.due(1 << 60))
    assert link.state() == other.state()
