"""How far a sample is from an even law, measured without any of the product's code."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

KOLMOGOROV_1_IN_10_000 = 2.23  # the bound that sqrt(n) times the gap exceeds once in 10,000 samples


def assert_even(values: ArrayLike, low: float = 0.0, high: float = 1.0) -> None:
    """Hold values to the even law between two bounds: Kolmogorov and Smirnov's test."""
    share = np.sort((np.asarray(values, np.float64).ravel() - low) / (high - low))
    assert share[0] >= -1e-12
    assert share[-1] <= 1 + 1e-12
    ranks = np.arange(len(share) + 1) / len(share)
    gap = max(np.max(ranks[1:] - share), np.max(share - ranks[:-1]))
    assert gap < KOLMOGOROV_1_IN_10_000 / np.sqrt(len(share))
