from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from waypointctl.flight.link.contacts import Contacts, Window, airtime_ns, always

S = 10**9


@given(st.integers(1, 1 << 20), st.floats(1, 1e12))
def test_no_rate_is_exceeded_and_no_nanosecond_is_wasted(size: int, rate_bps: float) -> None:
    took = airtime_ns(size, rate_bps)
    # In whole numbers: rate is n/d [bit/s], so bits * 1e9 <= rate * time is bits * 1e9 * d <= n * time.
    numerator, denominator = rate_bps.as_integer_ratio()
    assert 8 * size * S * denominator <= numerator * took
    assert 8 * size * S * denominator > numerator * (took - 1)
    assert always(rate_bps).place(5, size) == (5, 5 + took)


def test_without_a_rate_sending_takes_no_time() -> None:
    assert airtime_ns(1 << 40, None) == 0
    assert always().place(7, 1 << 40) == (7, 7)
    assert always().windows[0].end_ns == 2**62, "a time that a log can hold"


def test_a_window_can_be_used_from_its_beginning_to_its_end() -> None:
    contacts = Contacts([Window(10, 20, 8e9), Window(30, 35, 4e9)])
    assert contacts.place(0, 10) == (10, 20)
    assert contacts.place(11, 10) is None, "neither here nor in the next, where a byte takes 2 ns"
    assert contacts.place(19, 1) == (19, 20)
    assert contacts.place(19, 2) == (30, 34)
    assert contacts.place(20, 1) == (30, 32)
    assert contacts.place(34, 1) is None
    assert contacts.place(35, 1) is None


def test_windows_come_again() -> None:
    contacts = Contacts([Window(10, 20, 8e9), Window(30, 35, 8e9)], 100)
    assert [contacts.place(at, 5) for at in (0, 16, 31, 110, 131, 99_999)] == [
        (10, 15),
        (30, 35),
        (110, 115),
        (110, 115),
        (210, 215),
        (100_010, 100_015),
    ]
    assert contacts.place(125, 5) == (130, 135)
    assert contacts.place(0, 11) is None
    assert contacts.place(0, 10) == (10, 20), "a search forward does not spoil one back"


def test_the_next_opening() -> None:
    contacts = Contacts([Window(10, 20), Window(30, 40)], 50)
    assert [contacts.next_open_ns(at) for at in (0, 10, 15, 20, 39, 40, 60)] == [10, 10, 15, 30, 39, 60, 60]
    assert Contacts([Window(10, 20)]).next_open_ns(20) is None
    assert Contacts([]).next_open_ns(0) is None
    assert Contacts([Window(30, 40, 8e8)], 100).next_open_ns(35) == 35, "open, although no byte fits any more"


@given(st.integers(0, 10**18), st.integers(0, 1000))
def test_a_window_used_before_gives_what_a_fresh_look_gives(at: int, size: int) -> None:
    windows = [Window(3 * S, 50 * S, 1e4), Window(70 * S, 71 * S, 1e5), Window(90 * S, 100 * S)]
    used = Contacts(windows, 120 * S)
    for before in (at // 2, at, at + S):
        used.place(before, 10)
        assert used.place(at, size) == Contacts(windows, 120 * S).place(at, size)


@pytest.mark.parametrize(
    "window", [{"begin_ns": 5, "end_ns": 5}, {"begin_ns": -1, "end_ns": 5}, {"begin_ns": 0, "end_ns": 5, "rate_bps": 0}]
)
def test_refuses_a_window_that_nothing_can_be_sent_in(window: dict[str, int]) -> None:
    with pytest.raises(ValueError, match="is none"):
        Window(**window)


def test_refuses_windows_that_overlap_or_outlast_their_period() -> None:
    with pytest.raises(ValueError, match="overlap"):
        Contacts([Window(0, 10), Window(9, 20)])
    with pytest.raises(ValueError, match="after the period"):
        Contacts([Window(0, 10)], 9)


def test_the_window_used_last_counts_its_rate_and_its_end() -> None:
    contacts = Contacts([Window(0, 100, 4e9), Window(200, 300, 8e9)])
    assert contacts.place(0, 10) == (0, 20)
    assert contacts.place(20, 10) == (20, 40), "a byte takes 2 ns"
    assert contacts.place(80, 10) == (80, 100)
    assert contacts.place(81, 10) == (200, 210)
    assert contacts.place(210, 10) == (210, 220)


def test_the_window_used_last_rounds_up_a_byte_that_takes_a_fraction_of_nanoseconds() -> None:
    contacts = Contacts([Window(0, 100, 3e9)])
    assert [contacts.place(0, 3), contacts.place(8, 1), contacts.place(11, 3)] == [(0, 8), (8, 11), (11, 19)]


def test_windows_may_adjoin_and_end_with_their_period_and_be_as_slow_as_they_like() -> None:
    contacts = Contacts([Window(0, 10), Window(10, 20 * S, 0.5)], 20 * S)
    assert contacts.place(10, 1) == (10, 16 * S + 10)
    assert contacts.place(20 * S, 1) == (20 * S, 20 * S)


@pytest.mark.parametrize(
    ("windows", "period_ns", "gap_ns"),
    [
        ([], 0, 0),
        ([], 100, 0),
        ([Window(10, 20)], 0, 0),
        ([Window(10, 20)], 100, 90),
        ([Window(10, 20), Window(30, 35), Window(36, 40)], 0, 10),
        ([Window(10, 20), Window(30, 35)], 100, 75),
        ([Window(10, 40), Window(90, 100)], 100, 50),
    ],
)
def test_the_longest_gap_is_between_two_contacts(windows: list[Window], period_ns: int, gap_ns: int) -> None:
    assert Contacts(windows, period_ns).longest_gap_ns == gap_ns


@pytest.mark.parametrize(
    ("windows", "period_ns", "rate_bps"),
    [
        ([], 0, None),
        ([Window(0, 10)], 0, None),
        ([Window(0, 10, 5.0), Window(20, 30)], 100, None),
        ([Window(0, 10, 5.0), Window(20, 30, 7.0), Window(40, 50, 6.0)], 0, 7.0),
        ([Window(0, 10, 5.0)], 100, 0.5),
        ([Window(10, 20, 8.0), Window(30, 35, 4.0)], 100, 1.0),
    ],
)
def test_the_mean_rate_counts_each_contact_with_its_share_of_the_time(
    windows: list[Window], period_ns: int, rate_bps: float | None
) -> None:
    assert Contacts(windows, period_ns).mean_rate_bps == rate_bps


@pytest.mark.parametrize(("rates", "has"), [((None, None), False), ((None, 5.0), True), ((5.0, 7.0), True)])
def test_a_rate_in_one_contact_is_one(rates: tuple[float | None, float | None], has: bool) -> None:
    windows = [Window(10 * number, 10 * number + 5, rate) for number, rate in enumerate(rates)]
    assert Contacts(windows).has_rates is has
