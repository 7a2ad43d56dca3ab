"""Wilson's score interval of a success rate."""

from __future__ import annotations

import math
from statistics import NormalDist


def wilson_interval(successes: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return the interval (low, high) in which the true rate lies with the given confidence.

    Unlike the normal approximation it stays within [0, 1] and is meaningful for 0 or all of `trials`
    (E. B. Wilson 1927; method 3 in R. G. Newcombe, Statistics in Medicine 17, 1998).

    Raises:
        ValueError: not 0 <= successes <= trials, or no trials.
    """
    if not 0 <= successes <= trials or trials == 0:
        raise ValueError(f"{successes} of {trials} is not a rate")
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    rate = successes / trials
    centre = rate + z * z / (2 * trials)
    half = z * math.sqrt(rate * (1 - rate) / trials + z * z / (4 * trials * trials))
    scale = 1 + z * z / trials
    low = 0.0 if successes == 0 else (centre - half) / scale  # exactly, where rounding would leave 1e-17
    high = 1.0 if successes == trials else (centre + half) / scale
    return low, high
