from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from waypointctl.evaluation.result import wilson_interval


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [  # Newcombe, Statistics in Medicine 17 (1998), Table I, method 3
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0000, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_it_gives_the_published_intervals(successes: int, trials: int, low: float, high: float) -> None:
    assert list(wilson_interval(successes, trials)) == pytest.approx([low, high], abs=5e-5)


@given(st.integers(1, 500).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_its_ends_are_where_the_score_test_changes_its_mind(counts: tuple[int, int]) -> None:
    successes, trials = counts
    rate = successes / trials
    for end in wilson_interval(successes, trials):
        if 0 < end < 1:  # |rate - p| is 1.96 standard errors at the true rate p: what defines the interval
            assert abs(rate - end) / math.sqrt(end * (1 - end) / trials) == pytest.approx(1.959964, abs=1e-4)


@given(st.integers(1, 300))
def test_it_grows_with_the_successes_and_stays_within_0_and_1(trials: int) -> None:
    intervals = [wilson_interval(successes, trials) for successes in range(trials + 1)]
    assert intervals[0][0] == 0.0
    assert intervals[-1][1] == 1.0
    assert all(a[0] < b[0] and a[1] < b[1] for a, b in pairwise(intervals))


@pytest.mark.parametrize(("successes", "trials"), [(0, 0), (-1, 3), (4, 3)])
def test_what_is_no_rate_is_refused(successes: int, trials: int) -> None:
    with pytest.raises(ValueError, match="is not a rate"):
        wilson_interval(successes, trials)
