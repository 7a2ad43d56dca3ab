"""One seed, expanded by name into independent random streams.

A stream is found by its name, never by the order in which streams are made, so adding one never
shifts another.
"""

from __future__ import annotations

import hashlib

import numpy as np


def stream(seed: int, name: str, *index: int) -> np.random.Generator:
    """Return the random stream called `name` of `seed`.

    Args:
        seed: the mission's or training run's seed, not negative.
        name: what is drawn from the stream, such as "link.up" or "start".
        index: which of many alike, such as the trial or the robot's number.
    """
    digest = hashlib.sha256(name.encode()).digest()
    words = (int.from_bytes(digest[i : i + 4], "little") for i in (0, 4))
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed, spawn_key=(*words, *index))))
