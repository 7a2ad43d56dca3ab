from __future__ import annotations

import math
from dataclasses import fields

import numpy as np
import pytest
from pydantic import ValidationError

from tests.sim.bare import random_start
from waypointctl.task.config import SensorNoise
from waypointctl.task.randomized_robots import NoisySensors
from waypointctl.task.view import Body, body_of

# What a policy sees of the body, and the field of SensorNoise that it is off by.
SENSORS = {
    "position": "position_m",
    "velocity": "velocity_mps",
    "rates": "gyroscope_radps",
    "roll": "attitude_rad",
    "pitch": "attitude_rad",
    "yaw": "attitude_rad",
    "joints": "joint_angle_rad",
    "joint_rates": "joint_speed_radps",
}
ROBOTS = 4000


def bodies(robots: int, seed: int = 0) -> Body:
    rng = np.random.default_rng(seed)
    starts = [random_start(rng) for _ in range(min(robots, 20))]
    qpos, qvel = (np.stack(part) for part in zip(*starts, strict=True))
    return body_of(np.resize(qpos, (robots, 15)), np.resize(qvel, (robots, 14)))


def sensors(**deviations: float) -> NoisySensors:
    return NoisySensors(SensorNoise(**deviations), 8, np.random.default_rng(0))


@pytest.mark.parametrize("name", sorted(set(SENSORS.values())))
def test_each_deviation_is_that_of_its_sensors_and_of_no_other(name: str) -> None:
    body = bodies(ROBOTS)
    seen = sensors(**{name: 0.02}).read(body)
    for sensor, by in SENSORS.items():
        off = (getattr(seen, sensor) - getattr(body, sensor)).reshape(ROBOTS, -1)
        if by != name:
            np.testing.assert_array_equal(off, 0.0)
            continue
        off = (off + math.pi) % (2 * math.pi) - math.pi
        for column in off.T:  # 4000 numbers: their deviation is known to 1.1 %, their mean to 0.0003
            assert np.std(column) == pytest.approx(0.02, rel=0.05)
            assert abs(np.mean(column)) < 0.0016
            assert np.mean(np.abs(column) < 0.02) == pytest.approx(math.erf(math.sqrt(0.5)), abs=0.03)


def test_no_two_sensors_are_off_together() -> None:
    body = bodies(ROBOTS)
    seen = sensors(**dict.fromkeys(SensorNoise.model_fields, 0.001)).read(body)
    off = np.concatenate([(getattr(seen, name) - getattr(body, name)).reshape(ROBOTS, -1) for name in SENSORS], axis=1)
    assert off.shape == (ROBOTS, 28)
    correlation = np.corrcoef(off.T) - np.eye(28)
    assert np.abs(correlation).max() < 0.08


def test_each_reading_is_drawn_anew_and_the_body_stays_as_it_is() -> None:
    body = bodies(3)
    before = {field.name: getattr(body, field.name).copy() for field in fields(Body)}
    reader = sensors(position_m=0.1)
    first, second = reader.read(body), reader.read(body)
    assert not np.isclose(first.position, second.position).any()
    for name, values in before.items():
        np.testing.assert_array_equal(getattr(body, name), values)


def test_the_same_seed_reads_the_same_and_one_more_noisy_sensor_shifts_no_other() -> None:
    body = bodies(5)
    one, again = sensors(joint_angle_rad=0.1), sensors(joint_angle_rad=0.1)
    other = NoisySensors(SensorNoise(joint_angle_rad=0.1), 8, np.random.default_rng(7))
    both = sensors(joint_angle_rad=0.1, position_m=0.3)
    for _ in range(3):
        expected = one.read(body).joints
        np.testing.assert_array_equal(expected, again.read(body).joints)
        np.testing.assert_array_equal(expected, both.read(body).joints)
        assert not np.isclose(expected, other.read(body).joints).any()


def test_roll_and_yaw_stay_within_half_a_turn_and_up_is_that_of_the_tilt_seen() -> None:
    half = math.sqrt(0.5)
    backwards = np.tile([0.0, 0, 0.5, 1e-3, 0, 0, 1, *[0.0] * 8], (ROBOTS, 1))
    upside_down = np.tile([0.0, 0, 0.5, 1e-3, 1, 0, 0, *[0.0] * 8], (ROBOTS, 1))
    on_its_side = np.tile([0.0, 0, 0.5, half, half, 0, 0, *[0.0] * 8], (ROBOTS, 1))
    qvel = np.zeros((ROBOTS, 14))
    reader = sensors(attitude_rad=0.1)
    yaw = reader.read(body_of(backwards, qvel)).yaw
    roll = reader.read(body_of(upside_down, qvel)).roll
    for angle in (yaw, roll):
        assert np.abs(angle).max() <= math.pi
        assert min(np.mean(angle > 3.0), np.mean(angle < -3.0)) > 0.3, "both ways across half a turn"
    seen = reader.read(body_of(on_its_side, qvel))
    np.testing.assert_allclose(seen.up, np.cos(seen.roll) * np.cos(seen.pitch))
    assert np.std(seen.up) == pytest.approx(0.1, rel=0.1)


@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
@pytest.mark.parametrize("name", list(SensorNoise.model_fields))
def test_what_is_no_deviation_is_refused(name: str, value: float) -> None:
    with pytest.raises(ValidationError):
        SensorNoise(**{name: value})
