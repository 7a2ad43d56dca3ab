from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.flight.link.restored import restore_draws
from waypointctl.flight.link.impairments import (
    BLOCK,
    drawn_jitter,
    fixed_delay,
    normal_jitter,
    stepped_delay,
    table_delay,
    uniform_jitter,
)
from waypointctl.seeding import stream

COUNT = 20_000
DAY_NS = 86_400 * 10**9

TABLES = st.lists(
    st.tuples(st.integers(0, DAY_NS), st.integers(0, 5 * DAY_NS)), min_size=1, max_size=8, unique_by=lambda row: row[0]
).map(sorted)


def test_a_fixed_delay_never_changes() -> None:
    assert [fixed_delay(7)(at) for at in (0, 5, DAY_NS)] == [7, 7, 7]


@given(TABLES, st.integers(0, 2 * DAY_NS))
def test_a_table_is_interpolated_between_its_rows(table: list[tuple[int, int]], at: int) -> None:
    before = [row for row in table if row[0] <= at]
    after = [row for row in table if row[0] > at]
    if not before or not after:
        expected = Fraction((before[-1] if before else after[0])[1])
    else:
        (t0, d0), (t1, d1) = before[-1], after[0]
        expected = d0 + Fraction((d1 - d0) * (at - t0), t1 - t0)
    assert table_delay(table)(at) == math.floor(expected)


@given(TABLES, st.integers(0, 2 * DAY_NS))
def test_steps_hold_until_the_next_row(table: list[tuple[int, int]], at: int) -> None:
    assert stepped_delay(table)(at) == ([row for row in table if row[0] <= at] or table[:1])[-1][1]


@pytest.mark.parametrize("spread_ns", [1, 50_000_000, 3_000_000_000, 5 * DAY_NS])
def test_uniform_jitter_takes_the_streams_numbers_one_by_one(spread_ns: int) -> None:
    """Flights that were logged when each was drawn for itself fly the same."""
    jitter, rng = uniform_jitter(spread_ns, stream(3, "link.up")).draws, stream(3, "link.up")
    assert [jitter() for _ in range(1000)] == [
        int(rng.integers(-spread_ns, spread_ns, endpoint=True)) for _ in range(1000)
    ]


def test_uniform_jitter_lies_evenly_within_its_spread() -> None:
    jitter = uniform_jitter(1000, stream(0, "j"))
    drawn = np.array([jitter.draws() for _ in range(COUNT)])
    assert jitter.most_ns == 1000
    assert np.abs(drawn).max() == 1000
    counts, _ = np.histogram(drawn, bins=10, range=(-1000, 1001))
    assert np.abs(counts - COUNT / 10).max() < 5 * math.sqrt(COUNT * 0.09)


def test_normal_jitter_has_its_deviation_and_shape() -> None:
    jitter = normal_jitter(10_000_000, stream(0, "j"))
    drawn = np.array([jitter.draws() for _ in range(COUNT)]) / 10_000_000
    assert drawn.mean() == pytest.approx(0, abs=5 / math.sqrt(COUNT))
    assert drawn.std() == pytest.approx(1, abs=5 / math.sqrt(2 * COUNT))
    for bound in (0.5, 1.0, 2.0):  # against the normal distribution's own integral
        share = math.erf(bound / math.sqrt(2))
        assert (np.abs(drawn) < bound).mean() == pytest.approx(share, abs=5 * math.sqrt(share * (1 - share) / COUNT))
    assert (drawn * 10_000_000 > jitter.most_ns).mean() < 3e-4
    assert jitter.most_ns == 40_000_000


def test_measured_jitter_is_drawn_from_its_file_each_as_likely() -> None:
    samples = [-5, 0, 0, 100]
    jitter = drawn_jitter(samples, stream(0, "j"))
    drawn = [jitter.draws() for _ in range(COUNT)]
    assert jitter.most_ns == 100
    for value, share in ((-5, 0.25), (0, 0.5), (100, 0.25)):
        assert drawn.count(value) / COUNT == pytest.approx(share, abs=5 * math.sqrt(share * (1 - share) / COUNT))
    assert set(drawn) == set(samples)


@pytest.mark.parametrize("count", [0, 1, BLOCK - 1, BLOCK, BLOCK + 1])
def test_what_is_drawn_goes_on_where_its_state_was_taken(count: int) -> None:
    first, again = (uniform_jitter(1000, stream(0, "j")).draws for _ in range(2))
    for _ in range(count):
        first()
    state = first.state()
    assert state["used"] == count % BLOCK
    restore_draws(again, state)
    assert [again() for _ in range(BLOCK)] == [first() for _ in range(BLOCK)]
