from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from waypointctl.errors import InputError
from waypointctl.robots.load import load_robot
from waypointctl.task.config import DRAWN, DomainRandomization

ANT = load_robot("ant")


def test_values_lie_evenly_between_their_bounds() -> None:
    drawn = np.random.default_rng(0).random((20_000, len(DRAWN)))
    variation = DomainRandomization(
        latency_s=(0.0, 0.04), mass_factor=(0.5, 2.0), friction_factor=(0.2, 1.5), gravity_mps2=(1.62, 9.81)
    )
    values = variation.values(drawn, ANT)
    assert list(values) == ["latency_s", "mass_factor", "friction_factor", "gravity_mps2"]
    for name in ("mass_factor", "friction_factor", "gravity_mps2"):
        low, high = getattr(variation, name)
        share = (values[name] - low) / (high - low)
        np.testing.assert_allclose(np.histogram(share, 10, (0, 1))[0], 2000, atol=200)
        assert 0 <= share.min() < 1e-3
        assert 1 - 1e-3 < share.max() < 1


def test_every_latency_between_the_bounds_and_both_of_them_come_equally_often() -> None:
    drawn = np.random.default_rng(1).random((20_000, len(DRAWN)))
    latency_s = DomainRandomization(latency_s=(0.01, 0.04)).values(drawn, ANT)["latency_s"]
    values, counts = np.unique(latency_s, return_counts=True)
    np.testing.assert_allclose(values, [0.01, 0.02, 0.03, 0.04])
    np.testing.assert_allclose(counts, 5000, atol=300)


def test_equal_bounds_are_that_value_and_what_does_not_vary_is_left_out() -> None:
    drawn = np.array([[0.0] * 4, [np.nextafter(1.0, 0.0)] * 4])
    values = DomainRandomization(latency_s=(0.03, 0.03), gravity_mps2=(1.62, 1.62)).values(drawn, ANT)
    assert {name: value.tolist() for name, value in values.items()} == {
        "latency_s": [0.03, 0.03],
        "gravity_mps2": [1.62, 1.62],
    }
    assert DomainRandomization().values(drawn, ANT) == {}
    assert not DomainRandomization().any_drawn


def test_the_largest_draw_is_the_longest_latency_and_not_beyond() -> None:
    drawn = np.full((1, 4), np.nextafter(1.0, 0.0))
    for longest in range(100):
        variation = DomainRandomization(latency_s=(0.0, longest / 100))
        assert variation.values(drawn, ANT)["latency_s"][0] == pytest.approx(longest / 100)
        assert variation.latency_steps(ANT) == (0, longest)


@pytest.mark.parametrize(
    ("name", "bounds"),
    [
        ("latency_s", (-0.01, 0.04)),
        ("latency_s", (0.04, 0.0)),
        ("latency_s", (0.0, math.inf)),
        ("mass_factor", (0.0, 1.0)),
        ("mass_factor", (2.0, 1.0)),
        ("friction_factor", (math.nan, 1.0)),
        ("gravity_mps2", (1.0, math.nan)),
        ("gravity_mps2", (-9.81, 0.0)),
    ],
)
def test_bounds_that_make_no_sense_are_refused(name: str, bounds: tuple[float, float]) -> None:
    with pytest.raises(ValidationError):
        DomainRandomization.model_validate({name: bounds})


def test_a_latency_that_is_no_whole_number_of_physics_steps_is_refused() -> None:
    with pytest.raises(
        InputError,
        match=r"25 ms is not a whole number of the ant's physics steps of 10 ms; the nearest are 20 ms and 30 ms",
    ):
        DomainRandomization(latency_s=(0.0, 0.025)).latency_steps(ANT)
