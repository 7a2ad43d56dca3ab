from __future__ import annotations

import math

import pytest

from waypointctl.errors import InputError
from waypointctl.importers.local_frame import BODIES, LocalFrame, body_of, span_m


def test_a_minute_of_latitude_is_a_nautical_mile_and_one_of_longitude_at_the_equator_too() -> None:
    frame = LocalFrame((0.0, 0.0))
    # WGS 84: 110,574.3 m a degree of latitude and 111,319.5 m one of longitude, at the equator.
    assert frame.point((0.01, 0.0)) == pytest.approx((0, 1105.743), abs=0.01)
    assert frame.point((0.0, 0.01)) == pytest.approx((1113.195, 0), abs=0.01)


def test_degrees_at_45_degrees_are_those_of_the_tables() -> None:
    frame = LocalFrame((45.0, 7.0))
    assert frame.point((45.01, 7.0)) == pytest.approx((0, 1111.32), abs=0.05)  # 111,132 m a degree
    assert frame.point((45.0, 7.01)) == pytest.approx((788.47, 0), abs=0.06)  # 78,847 m a degree


def test_the_way_across_the_date_line_is_the_short_one() -> None:
    x, _ = LocalFrame((10.0, 179.999)).point((10.0, -179.999))
    assert 0 < x < 250


@pytest.mark.parametrize("latitude", [-60.0, 0.0, 45.0, 70.0])
def test_a_place_far_off_the_axes_is_where_the_plane_that_touches_the_origin_has_it(latitude: float) -> None:
    origin, place = (latitude, 12.0), (latitude + 0.03, 12.08)
    phi, lam = math.radians(place[0]), math.radians(place[1] - origin[1])
    phi_0, radius_m = math.radians(latitude), 1_737_400.0
    east = radius_m * math.cos(phi) * math.sin(lam)
    north = radius_m * (math.sin(phi) * math.cos(phi_0) - math.cos(phi) * math.cos(lam) * math.sin(phi_0))
    # The plane is shorter than the ground by s^3 / 6 R^2: a millimetre at 2.6 km on the Moon.
    assert LocalFrame(origin, BODIES["moon"]).point(place) == pytest.approx((east, north), abs=0.002)


def test_a_frame_at_the_pole_has_all_directions() -> None:
    frame = LocalFrame((-90.0, 0.0), BODIES["moon"])
    degree_m = 1_737_400.0 * math.pi / 180
    assert frame.point((-89.9, 0.0)) == pytest.approx((0, 0.1 * degree_m), abs=0.001)
    assert frame.point((-89.9, 90.0)) == pytest.approx((0.1 * degree_m, 0), abs=0.001)


def test_a_span_is_the_longer_side() -> None:
    assert span_m([(0, 0), (3, -4), (1, 6)]) == 10


@pytest.mark.parametrize(
    ("body", "north_m", "east_m"),
    [
        ("earth", 11.057, 11.132),  # WGS 84 at the equator
        ("moon", 3.032, 3.032),  # 2 pi 1737.4 km / 3.6 million
        ("mars", 5.927, 5.927),
        (" Moon ", 3.032, 3.032),
        ("1737.4 km", 3.032, 3.032),
        ("1737400m", 3.032, 3.032),
    ],
)
def test_a_ten_thousandth_of_a_degree_is_as_long_as_its_body_is_large(body: str, north_m: float, east_m: float) -> None:
    x, y = LocalFrame((0.0, 20.0), body_of(body)).point((0.0001, 20.0001))
    assert (x, y) == pytest.approx((east_m, north_m), abs=0.001)


def test_on_a_sphere_the_frame_is_that_of_its_radius_everywhere() -> None:
    frame = LocalFrame((60.0, 350.0), BODIES["moon"])
    assert frame.point((60.01, 350.0)) == pytest.approx((0, 303.23), abs=0.01)
    assert frame.point((60.0, 350.02)) == pytest.approx((0.5 * 606.47, 0), abs=0.05)
    assert frame.point((60.0, -10.0)) == pytest.approx((0, 0))


def test_a_small_body_has_a_small_frame() -> None:
    assert LocalFrame((0, 0)).max_span_m == 10_000
    assert LocalFrame((0, 0), body_of("100 km")).max_span_m == 1000


@pytest.mark.parametrize("text", ["pluto", "1737400", "", "nan km", "1 km", "1e9 km", "-5 km", "inf km"])
def test_what_is_no_body_is_refused(text: str) -> None:
    with pytest.raises(InputError, match=r"^--body: .* is not a (body|radius)"):
        body_of(text)
