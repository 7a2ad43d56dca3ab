from __future__ import annotations

from itertools import pairwise, product

import numpy as np
import pytest

from waypointctl.flight.forecast.chain import Chain
from waypointctl.flight.link.loss import GilbertElliott, RandomLoss
from waypointctl.mission.link import Bursts, Loss

LOSSES = (0.4, Bursts(p=0.3, r=0.2), Bursts(p=0.05, r=0.4, one_minus_h=0.8, one_minus_k=0.02), Bursts(p=1.0, r=0.0))
FLIGHTS = 4_000


def by_enumeration(loss: Loss, messages: int, run: int) -> float:
    """Return the probability of a run, by going through every course of a link that begins good, and every fate."""
    bursts = loss if isinstance(loss, Bursts) else Bursts(p=0.0, r=0.0, one_minus_k=loss)
    change = {(0, 1): bursts.p, (0, 0): 1 - bursts.p, (1, 0): bursts.r, (1, 1): 1 - bursts.r}
    risk = (bursts.one_minus_k, bursts.one_minus_h)
    total = 0.0
    for states in product((0, 1), repeat=messages):
        course = float(states[0] == 0)
        for before, after in pairwise(states):
            course *= change[before, after]
        for fates in product((True, False), repeat=messages) if course else ():
            if "x" * run in "".join("x" if lost else "." for lost in fates):
                chances = [risk[state] if lost else 1 - risk[state] for state, lost in zip(states, fates, strict=True)]
                total += course * float(np.prod(chances))
    return total


@pytest.mark.parametrize("loss", LOSSES)
@pytest.mark.parametrize(("messages", "run"), [(1, 1), (4, 2), (6, 1), (6, 3), (2, 3)])
def test_runs_are_as_likely_as_counting_every_case_says(loss: Loss, messages: int, run: int) -> None:
    chain = Chain(loss)
    assert chain.run_lost(chain.after(0), messages, run) == pytest.approx(
        by_enumeration(loss, messages, run), abs=1e-12
    )
    assert chain.all_lost(chain.after(0), messages) == pytest.approx(
        by_enumeration(loss, messages, messages), abs=1e-12
    )


@pytest.mark.parametrize("loss", LOSSES)
def test_runs_are_as_frequent_as_on_the_link_that_is_flown(loss: Loss) -> None:
    found = 0
    for seed in range(FLIGHTS):
        rng = np.random.default_rng(seed)
        model = (
            GilbertElliott(loss.p, loss.r, loss.one_minus_h, loss.one_minus_k, rng)
            if isinstance(loss, Bursts)
            else RandomLoss(loss, rng)
        )
        found += "xxx" in "".join("x" if model() else "." for _ in range(12))
    chain = Chain(loss)
    assert chain.run_lost(chain.after(0), 12, 3) == pytest.approx(found / FLIGHTS, abs=0.025)


def test_long_times_go_on_as_they_began() -> None:
    chain = Chain(Bursts(p=0.001, r=0.3))
    spared = [1 - chain.run_lost(chain.after(0), messages, 8) for messages in (5_000, 10_000, 40_000)]
    assert spared[1] == pytest.approx(spared[0] ** 2, rel=0.01)
    assert spared[2] == pytest.approx(spared[1] ** 4, rel=0.01)


def test_a_link_in_the_long_run_is_bad_for_its_share() -> None:
    assert Chain(Bursts(p=0.3, r=0.2)).after(1_000) == pytest.approx([0.4, 0.6])
    assert Chain(0.3).after(1_000) == pytest.approx([1.0, 0.0])
