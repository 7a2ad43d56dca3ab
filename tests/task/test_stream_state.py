from __future__ import annotations

import numpy as np

from waypointctl.seeding import restore_stream, stream, stream_words


def test_a_stream_goes_on_from_its_words_even_with_half_a_word_to_spare() -> None:
    for draws in range(5):
        original = stream(3, "here", draws)
        original.integers(100, size=draws, dtype=np.uint32)  # an odd number leaves half a word
        words = stream_words(original)
        assert words.shape == (6,)
        assert words[4] == draws % 2
        other = stream(99, "elsewhere")
        restore_stream(other, words)
        assert other.bit_generator.state == original.bit_generator.state
        np.testing.assert_array_equal(
            other.integers(100, size=9, dtype=np.uint32), original.integers(100, size=9, dtype=np.uint32)
        )
        np.testing.assert_array_equal(other.standard_normal(9), original.standard_normal(9))
