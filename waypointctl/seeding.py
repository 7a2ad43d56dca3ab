"""One seed, expanded by name into independent random streams.

A stream is found by its name, never by the order in which streams are made, so adding one never
shifts another.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

_WORD: Final = 2**64


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


def stream_words(rng: np.random.Generator) -> NDArray[np.uint64]:
    """Return the state of a PCG64 stream as an array (6,), so that checkpoints can hold hundreds of them.

    It has state and increment, the low half first, and a spare half word.
    """
    whole = rng.bit_generator.state
    state, increment = whole["state"]["state"], whole["state"]["inc"]
    halves = (state % _WORD, state // _WORD, increment % _WORD, increment // _WORD)
    return np.array([*halves, whole["has_uint32"], whole["uinteger"]], np.uint64)


def streams_words(streams: Sequence[np.random.Generator]) -> NDArray[np.uint64]:
    """Return the states of PCG64 streams, (n, 6)."""
    return np.stack([stream_words(rng) for rng in streams])


def restore_streams(streams: Sequence[np.random.Generator], words: NDArray[np.uint64]) -> None:
    """Put PCG64 streams into the states that `streams_words` returned."""
    for rng, state in zip(streams, words, strict=True):
        restore_stream(rng, state)


def restore_stream(rng: np.random.Generator, words: NDArray[np.uint64]) -> None:
    """Put a PCG64 stream into the state that `stream_words` returned."""
    low, high, increment_low, increment_high, has_spare, spare = (int(word) for word in words)
    rng.bit_generator.state = {
        "bit_generator": "PCG64",
        "state": {"state": high * _WORD + low, "inc": increment_high * _WORD + increment_low},
        "has_uint32": has_spare,
        "uinteger": spare,
    }
