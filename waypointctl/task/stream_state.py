"""The state of a random stream as an array, so that checkpoints can hold hundreds of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Words = NDArray[np.uint64]

_WORD = 2**64


def stream_words(rng: np.random.Generator) -> Words:
    """Return the state of a PCG64 stream, (6,): state and increment, low half first, and a spare half word."""
    whole = rng.bit_generator.state
    state, increment = whole["state"]["state"], whole["state"]["inc"]
    halves = (state % _WORD, state // _WORD, increment % _WORD, increment // _WORD)
    return np.array([*halves, whole["has_uint32"], whole["uinteger"]], np.uint64)


def restore_stream(rng: np.random.Generator, words: Words) -> None:
    """Put a PCG64 stream into the state that `stream_words` returned."""
    low, high, increment_low, increment_high, has_spare, spare = (int(word) for word in words)
    rng.bit_generator.state = {
        "bit_generator": "PCG64",
        "state": {"state": high * _WORD + low, "inc": increment_high * _WORD + increment_low},
        "has_uint32": has_spare,
        "uinteger": spare,
    }
