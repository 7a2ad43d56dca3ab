from __future__ import annotations

import numpy as np
import pytest

from waypointctl.mission.onboard import Zone
from waypointctl.replay.track import Extent, extent


def square(half_m: float) -> Zone:
    return Zone("z", True, ((-half_m, -half_m), (half_m, -half_m), (half_m, half_m), (-half_m, half_m)))


@pytest.mark.parametrize(
    ("half_m", "expected"),
    [
        (1, Extent(-1, 10, -1, 4)),
        (5, Extent(-5, 10, -5, 5)),
        (9000, Extent(-5, 15, -5, 9)),  # half the larger side of the way beyond it, and no more
    ],
)
def test_a_map_holds_the_way_and_zones_that_are_near(half_m: float, expected: Extent) -> None:
    x_m, y_m = np.array([0.0, 10.0, 5.0]), np.array([0.0, 0.0, 4.0])
    zone = square(half_m)
    assert extent(x_m, y_m, [zone]) == expected


def test_a_map_of_nothing_is_a_map() -> None:
    assert extent(np.zeros(0), np.zeros(0)) == Extent(-1, 1, -1, 1)
