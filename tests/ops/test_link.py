from __future__ import annotations

from dataclasses import dataclass

from hypothesis import given, settings
from hypothesis import strategies as st

from waypointctl.ops.link import Link
from waypointctl.seeding import stream


@dataclass(frozen=True)
class Letter:
    number: int
    issued_ns: int
    received_ns: int


def link_of(delay_ns: int, jitter_ns: int = 0, seed: int = 0) -> Link[Letter]:
    return Link(delay_ns, jitter_ns, stream(seed, "link"))


def post(link: Link[Letter], number: int, now_ns: int) -> Letter:
    return link.send(now_ns, lambda arrives_ns: Letter(number, now_ns, arrives_ns))


SENDINGS = st.lists(st.integers(0, 500), min_size=1, max_size=60)  # [ns] between one sending and the next
DELAYS = st.integers(0, 1000).flatmap(lambda delay: st.tuples(st.just(delay), st.integers(0, delay)))


@given(SENDINGS, DELAYS, st.integers(0, 50), st.integers(1, 400))
@settings(max_examples=300, deadline=None)
def test_nothing_is_early_lost_or_doubled_and_the_order_is_kept(
    gaps: list[int], way: tuple[int, int], seed: int, tick_ns: int
) -> None:
    delay, jitter = way
    link = link_of(delay, jitter, seed)
    sent: list[Letter] = []
    heard: list[Letter] = []
    times = [sum(gaps[: i + 1]) for i in range(len(gaps))]
    for now in range(0, times[-1] + 2 * 1000 + tick_ns, tick_ns):
        while len(sent) < len(times) and times[len(sent)] <= now:
            sent.append(post(link, len(sent), times[len(sent)]))
        for letter in link.due(now):
            assert letter.received_ns <= now, "early"
            assert letter.received_ns > now - tick_ns or letter.issued_ns > now - tick_ns, "forgotten for a while"
            heard.append(letter)
    assert heard == sent
    arrivals = [letter.received_ns for letter in heard]
    assert arrivals == sorted(arrivals)
    for letter in heard:
        assert delay - jitter <= letter.received_ns - letter.issued_ns <= delay + jitter


@given(SENDINGS, DELAYS, st.integers(0, 50))
@settings(max_examples=100, deadline=None)
def test_the_same_seed_delivers_at_the_same_times(gaps: list[int], way: tuple[int, int], seed: int) -> None:
    first, second = link_of(*way, seed), link_of(*way, seed)
    now = 0
    for number, gap in enumerate(gaps):
        now += gap
        assert post(first, number, now) == post(second, number, now)


def test_jitter_uses_all_of_its_range_and_another_seed_is_another_trace() -> None:
    spread = 1000
    arrivals = [post(link_of(spread, spread, seed), 0, 0).received_ns for seed in range(300)]
    assert min(arrivals) < 0.05 * 2 * spread
    assert max(arrivals) > 0.95 * 2 * spread
    assert len(set(arrivals)) > 200


def test_without_jitter_the_delay_is_the_delay() -> None:
    link = link_of(1_280_000_000)
    assert [post(link, i, 7 * i).received_ns for i in range(4)] == [1_280_000_000 + 7 * i for i in range(4)]
    assert list(link.due(1_279_999_999)) == []
    assert [letter.number for letter in link.due(1_280_000_007)] == [0, 1]
    assert [letter.number for letter in link.in_transit] == [2, 3]


def test_nothing_overtakes_what_was_sent_before_it() -> None:
    link = link_of(1000, 1000, seed=1)
    letters = [post(link, number, number) for number in range(200)]
    jitters = [letter.received_ns - letter.issued_ns for letter in letters]
    assert len({letter.received_ns for letter in letters}) < 200, "some had to wait for those before them"
    assert min(jitters) >= 0
    assert [letter.number for letter in link.due(10_000)] == list(range(200))


def test_what_is_sent_while_the_mail_is_read_is_read_too() -> None:
    link = link_of(0)
    post(link, 0, 0)
    numbers = []
    for letter in link.due(0):
        numbers.append(letter.number)
        if letter.number < 3:
            post(link, letter.number + 1, 0)
    assert numbers == [0, 1, 2, 3]
