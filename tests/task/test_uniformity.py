from __future__ import annotations

import numpy as np
import pytest

from tests.task.uniformity import assert_even


def test_an_even_sample_passes_and_one_a_little_uneven_does_not() -> None:
    even = np.random.default_rng(0).random(4000)
    assert_even(even)
    assert_even(3 + 2 * even, 3, 5)
    for uneven in (even**1.1, 0.95 * even, 0.5 + (even - 0.5) ** 3, np.append(even, 1.1)):
        with pytest.raises(AssertionError):
            assert_even(uneven)
