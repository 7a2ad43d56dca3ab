"""What one direction of the link does with chance, and in the cases that are easily got wrong."""

from __future__ import annotations

import sys
from functools import partial

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.flight.link.made import Told, chancy, told_jitter
from tests.flight.link.restored import restore
from waypointctl.flight.link.contacts import Contacts, Window
from waypointctl.flight.link.direction import NO_CONTACT, NOISE, QUEUE_FULL, Direction, Duplication
from waypointctl.flight.link.impairments import (
    BLOCK,
    RandomLoss,
    drawn_jitter,
    fixed_delay,
    table_delay,
    uniform_jitter,
)
from waypointctl.seeding import stream


def luck(link: Direction[int], sizes: list[int], gap: int) -> list[tuple[int, str]]:
    """Return of each message how long it was under way after it had left, and why it was lost on the way if it was."""
    deliveries = [link.send(gap * number, size, lambda when: when) for number, size in enumerate(sizes)]
    return [
        (delivery.arrivals_ns[0] - delivery.left_ns if delivery.arrivals_ns else -1, delivery.lost)
        for delivery in deliveries
    ]


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


def following(number: int, _: int) -> int:
    return number + 1


def test_a_doubled_message_that_is_lost_arrives_once() -> None:
    link = Direction[int](loss=Told([True, False, True]), duplication=Duplication(Told([True, True, False])))
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


def test_a_mebibyte_can_wait_where_nothing_else_is_said() -> None:
    for size, lost in ((1 << 20, ""), ((1 << 20) + 1, QUEUE_FULL)):
        link = Direction[int](contacts=Contacts([Window(1000, 1 << 40)]))
        assert link.send(0, size, lambda when: when).lost == lost


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


def test_the_latest_arrival_counts_no_jitter_that_only_shortens_the_way() -> None:
    for most_ns in (0, -5):
        link = Direction[int](delay=fixed_delay(100), jitter=drawn_jitter([-9, most_ns], stream(0, "j")))
        assert link.latest_arrival_ns(7, 1) == 107


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

    assert calls(5 * 86_400 * 10**9) <= 1.01 * calls(0), "blocks of draws are not shared out alike"


def test_the_latest_arrival_is_not_before_that_of_what_was_sent_earlier_where_order_is_kept() -> None:
    falling = table_delay([(0, 1000), (100, 0)])
    for ordered, latest_ns in ((True, 1000), (False, 100)):
        link = Direction[int](delay=falling, keeps_order=ordered)
        link.send(0, 1, lambda when: when)
        assert link.latest_arrival_ns(100, 1) == latest_ns


def test_a_duplicate_has_a_jitter_of_its_own_and_arrivals_are_in_order() -> None:
    link = Direction[int](
        delay=fixed_delay(100),
        jitter=told_jitter([50, 0]),
        keeps_order=False,
        duplication=Duplication(Told([True, True]), told_jitter([20, 30])),
    )
    assert link.send(0, 1, lambda when: when).arrivals_ns == (120, 150)
    assert link.next_arrival_ns == 120
    assert link.send(1, 1, lambda when: when).arrivals_ns == (101, 131)
    assert (link.next_arrival_ns, [when for when, _ in link.under_way]) == (101, [101, 120, 131, 150])
    assert list(link.due(131)) == [101, 120, 131]
    alike = Direction[int](duplication=Duplication(Told([True])))
    assert alike.send(7, 1, lambda when: when).arrivals_ns == (7, 7)


def test_a_link_is_dead_when_all_is_lost_or_no_contact_is_left() -> None:
    everything = Told([])
    everything.loses_all = True
    assert Direction[int](loss=everything).is_dead(0)
    assert not Direction[int](loss=everything, duplication=Duplication(Told([]))).is_dead(0)
    assert not Direction[int](loss=Told([])).is_dead(0)
    assert not Direction[int]().is_dead(0)
    closing = Direction[int](contacts=Contacts([Window(0, 100, 8e9)]))
    assert (closing.is_dead(99), closing.is_dead(100)) == (False, True)
    closing.send(0, 99, lambda when: when)
    assert not closing.is_dead(0)
    closing.send(0, 1, lambda when: when)
    assert closing.is_dead(0), "all of the contact is taken"


def test_all_that_waits_counts_against_the_queue() -> None:
    link = Direction[int](contacts=Contacts([Window(1000, 1 << 40, 8e9)]), queue_bytes=30)
    assert [link.send(0, 10, lambda when: when).lost for _ in range(4)] == ["", "", "", QUEUE_FULL]
    assert [link.waiting_bytes(at) for at in (999, 1000, 1010, 1020)] == [30, 20, 10, 0]
    assert link.send(1020, 10, lambda when: when).departs_ns == 1030


def test_a_link_goes_on_where_its_state_was_taken() -> None:
    def made() -> Direction[int]:
        second = Duplication(RandomLoss(0.5, stream(1, "twice")), uniform_jitter(50, stream(1, "second")))
        return chancy(4, losing=0.3, duplication=second, contacts=Contacts([Window(0, 1 << 40, 8e9)]))

    first, again = made(), made()
    for number in range(300):
        first.send(10 * number, 20, lambda when: when)
    restore(again, first.state(), first.under_way)
    assert again.under_way == first.under_way
    assert again.waiting_bytes(3000) == first.waiting_bytes(3000) > 0
    for number in range(300, 400):
        sent = [link.send(10 * number, 20, lambda when: when) for link in (first, again)]
        assert sent[0] == sent[1]
    assert list(again.due(1 << 60)) == list(first.due(1 << 60))
