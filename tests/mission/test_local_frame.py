from __future__ import annotations

import math

import pytest

from waypointctl.mission.local_frame import LocalFrame, span_m


def test_a_minute_of_latitude_is_a_nautical_mile_and_one_of_longitude_at_the_equator_too() -> None:
    frame = LocalFrame((0.0, 0.0))
    # WGS 84: 110,574.3 m a degree of latitude and 111,319.5 m one of longitude, at the equator.
    assert frame.point((0.01, 0.0)) == pytest.approx((0, 1105.743), abs=0.01)
    assert frame.point((0.0, 0.01)) == pytest.approx((1113.195, 0), abs=0.01)


def test_degrees_at_45_degrees_are_those_of_the_tables() -> None:
    x, y = LocalFrame((45.0, 7.0)).point((45.01, 7.01))
    assert (x, y) == pytest.approx((788.47, 1111.32), abs=0.05)  # 78,847 m and 111,132 m a degree


def test_the_way_across_the_date_line_is_the_short_one() -> None:
    x, _ = LocalFrame((10.0, 179.999)).point((10.0, -179.999))
    assert 0 < x < 250


@pytest.mark.parametrize("latitude", [-60.0, 0.0, 45.0, 70.0])
def test_the_error_is_that_of_meridians_coming_together(latitude: float) -> None:
    frame = LocalFrame((latitude, 12.0))
    corner = (latitude + 0.02, 12.02)
    x, y = frame.point(corner)
    radius_m = 6_371_000.0
    convergence = math.tan(math.radians(latitude))
    # To second order: x is too long by x y tan / R, and y too short by x^2 tan / 2R.
    expected = math.hypot(x * y * convergence / radius_m, x * x * convergence / (2 * radius_m))
    assert frame.error_m([corner]) == pytest.approx(expected, rel=0.05, abs=0.01)
    assert frame.error_m([(latitude, 12.0)]) < 1e-9


def test_a_span_is_the_longer_side() -> None:
    assert span_m([(0, 0), (3, -4), (1, 6)]) == 10
