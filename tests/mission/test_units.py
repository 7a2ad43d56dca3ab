from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from waypointctl.units import (
    ANGLE_UNITS_DEG,
    ANGLE_UNITS_RAD,
    DISTANCE_UNITS_M,
    DURATION_UNITS_S,
    RATE_UNITS_BPS,
    SHARE_UNITS,
    SIZE_UNITS_BYTES,
    bare_name,
    ns,
    quantity,
    seconds,
)


@pytest.mark.parametrize(
    ("text", "units", "value"),
    [
        ("1.28 s", DURATION_UNITS_S, 1.28),
        ("50ms", DURATION_UNITS_S, 0.05),
        ("70 cm", DISTANCE_UNITS_M, 0.7),  # 70 * 0.01 is 0.7000000000000001
        (" +2e1 min ", DURATION_UNITS_S, 1200.0),
        (".5 km", DISTANCE_UNITS_M, 500.0),
        ("-90 deg", ANGLE_UNITS_DEG, -90.0),
        ("1e999999999 s", DURATION_UNITS_S, math.inf),
        ("1e-999999999 s", DURATION_UNITS_S, 0.0),
        ("1e-99999999999999999999 s", DURATION_UNITS_S, 0.0),
        ("0e99999999999999999999 s", DURATION_UNITS_S, 0.0),
        ("-1e99999999999999999999 s", DURATION_UNITS_S, -math.inf),
        ("0.1 rad", ANGLE_UNITS_RAD, 0.1),
        ("64 kbit/s", RATE_UNITS_BPS, 64_000.0),
        ("2KiB", SIZE_UNITS_BYTES, 2048.0),
        ("1.5 MB", SIZE_UNITS_BYTES, 1_500_000.0),
        ("7 %", SHARE_UNITS, 0.07),
    ],
)
def test_reads_a_number_with_its_unit(text: str, units: dict[str, float], value: float) -> None:
    assert quantity(text, units) == value


def test_degrees_become_radians() -> None:
    assert quantity("180 deg", ANGLE_UNITS_RAD) == pytest.approx(math.pi, rel=1e-15)


def test_radians_become_degrees() -> None:
    assert quantity("3.141592653589793 rad", ANGLE_UNITS_DEG) == pytest.approx(180.0, rel=1e-15)


@pytest.mark.parametrize("text", ["", "5", "m", "5 m s", "5,0 m", "1_0 m", "--1 m", "0x5 m", "nan m", "٣ m"])
def test_refuses_what_is_no_number_with_a_unit(text: str) -> None:
    with pytest.raises(ValueError, match="is not a number with a unit"):
        quantity(text, DISTANCE_UNITS_M)


def test_refuses_another_unit_and_names_the_right_ones() -> None:
    with pytest.raises(ValueError, match="has the unit 'ft'; allowed are mm, cm, m, km"):
        quantity("5 ft", DISTANCE_UNITS_M)


@given(st.integers(-(10**12), 10**12))
def test_milliseconds_are_rounded_once(count: int) -> None:
    assert quantity(f"{count} ms", DURATION_UNITS_S) == count / 1000


@given(st.integers(0, 10**15))
def test_nanoseconds_come_back(time_ns: int) -> None:
    assert ns(seconds(time_ns)) == time_ns


@pytest.mark.parametrize(
    ("name", "bare"),
    [
        ("timeout_s", "timeout"),
        ("rate_hz", "rate"),
        ("spread_rad", "spread"),
        ("max_time_s", "max_time"),
        ("name", None),
        ("on_failure", None),
    ],
)
def test_the_bare_name_of_a_field(name: str, bare: str | None) -> None:
    assert bare_name(name) == bare
