"""The models of loss against their closed forms, and against numbers that were worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.flight.link.restored import restore_draws
from waypointctl.flight.link.impairments import BLOCK, GilbertElliott, RandomLoss
from waypointctl.seeding import stream

COUNT = 200_000

MODELS = [(0.01, 0.3, 1.0, 0.0), (0.05, 0.2, 0.5, 0.001), (0.3, 0.1, 0.9, 0.05), (1.0, 1.0, 1.0, 0.0)]


def deliveries(model: tuple[float, float, float, float], seed: int = 0) -> np.ndarray:
    loss = GilbertElliott(*model, stream(seed, "loss"))
    return np.array([loss() for _ in range(COUNT)])


@pytest.mark.parametrize("model", MODELS)
def test_bursts_lose_what_the_closed_form_says_in_the_long_run(model: tuple[float, float, float, float]) -> None:
    p, r, lost_in_bad, lost_in_good = model
    bad = p / (p + r)
    share = bad * lost_in_bad + (1 - bad) * lost_in_good
    # The link's state is a Markov chain whose correlation falls by 1 - p - r a message: so many fewer count as apart.
    apart = COUNT * (p + r) / (2 - p - r) if p + r < 2 else COUNT
    assert deliveries(model).mean() == pytest.approx(share, abs=5 * math.sqrt(share * (1 - share) / apart) + 2 / COUNT)


@pytest.mark.parametrize(("p", "r"), [(0.01, 0.3), (0.05, 0.2), (0.2, 0.8)])
def test_bursts_last_as_long_as_the_closed_form_says(p: float, r: float) -> None:
    """With 1-h = 1 and 1-k = 0 what is lost is what meets the bad link: bursts of 1/r messages, 1/p apart."""
    lost = deliveries((p, r, 1.0, 0.0)).astype(int)
    begins, ends = np.flatnonzero(np.diff(lost) == 1), np.flatnonzero(np.diff(lost) == -1)
    bursts = ends[: len(begins)] - begins[: len(ends)]
    gaps = begins[1:] - ends[: len(begins) - 1]
    for lengths, leave in ((bursts, r), (gaps, p)):
        deviation = math.sqrt(1 - leave) / leave / math.sqrt(len(lengths))
        assert lengths.mean() == pytest.approx(1 / leave, abs=5 * deviation)
        assert (lengths == 1).mean() == pytest.approx(leave, abs=5 * math.sqrt(leave * (1 - leave) / len(lengths)))


def test_a_message_fares_as_the_link_is_when_it_is_handed_over_and_then_the_link_changes() -> None:
    """As Linux's sch_netem.c has it: the first message meets a good link, and each change counts from the next one."""
    loss = GilbertElliott(1.0, 1.0, 1.0, 0.0, stream(0, "loss"))
    assert [loss() for _ in range(6)] == [False, True, False, True, False, True]


def test_bursts_follow_the_streams_numbers_one_by_one() -> None:
    p, r, lost_in_bad, lost_in_good = 0.3, 0.4, 0.8, 0.2
    rng, bad, expected = stream(7, "loss"), False, []
    for _ in range(1000):
        change, delivery = rng.random(), rng.random()
        expected.append(delivery < (lost_in_bad if bad else lost_in_good))
        bad = change >= r if bad else change < p
    loss = GilbertElliott(p, r, lost_in_bad, lost_in_good, stream(7, "loss"))
    assert [loss() for _ in range(1000)] == expected


def test_random_loss_loses_its_share_and_no_message_minds_the_one_before() -> None:
    loss = RandomLoss(0.1, stream(0, "loss"))
    lost = np.array([loss() for _ in range(COUNT)])
    assert lost.mean() == pytest.approx(0.1, abs=5 * math.sqrt(0.09 / COUNT))
    assert lost[1:][lost[:-1]].mean() == pytest.approx(0.1, abs=5 * math.sqrt(0.09 / (0.1 * COUNT)))


@pytest.mark.parametrize(("probability", "all_alike"), [(0.0, False), (1.0, True)])
def test_certainty_is_certain(probability: float, all_alike: bool) -> None:
    loss = RandomLoss(probability, stream(0, "loss"))
    assert {loss() for _ in range(1000)} == {all_alike}


@pytest.mark.parametrize(
    ("model", "bad", "loses_all"),
    [
        ((0.1, 0.0, 1.0, 0.5), True, True),
        ((0.1, 0.0, 1.0, 0.5), False, False),
        ((0.1, 0.1, 1.0, 0.5), True, False),
        ((0.1, 0.0, 0.9, 0.5), True, False),
        ((0.1, 0.1, 1.0, 1.0), False, True),
        ((0.1, 0.1, 0.9, 1.0), False, False),
    ],
)
def test_a_bursty_link_loses_all_where_it_never_gets_good_or_is_lossy_in_both(
    model: tuple[float, float, float, float], bad: bool, loses_all: bool
) -> None:
    loss = GilbertElliott(*model, stream(0, "loss"))
    loss.bad = bad
    assert loss.loses_all is loses_all


def test_a_random_loss_loses_all_only_where_it_is_certain() -> None:
    assert [RandomLoss(share, stream(0, "loss")).loses_all for share in (0.0, 0.99, 1.0)] == [False, False, True]


@pytest.mark.parametrize("count", [0, 1, BLOCK - 1, BLOCK, BLOCK + 7])
def test_a_bursty_link_goes_on_where_its_state_was_taken(count: int) -> None:
    first, again = (GilbertElliott(0.3, 0.4, 0.8, 0.2, stream(5, "loss")) for _ in range(2))
    for _ in range(count):
        first()
    state = first.state()
    assert state["used"] == count % BLOCK
    restore_draws(again, state)
    assert [again() for _ in range(2 * BLOCK)] == [first() for _ in range(2 * BLOCK)]
