from __future__ import annotations

import math
from pathlib import Path

import fastjsonschema
import pytest

from tests.training.tiny import RECIPE, tiny_recipe
from waypointctl.errors import RecipeError
from waypointctl.mission.yaml_tree import read_tree
from waypointctl.task.config import DomainRandomization, SensorNoise
from waypointctl.training.recipe_file import recipe_schema

BARE = """\
domain_randomization:
  latency: [0 ms, 40 ms]
  mass_factor: [0.8, 1.25]
  friction_factor: [0.5, 1.5]
  gravity_mps2: [1.62, 9.81]
  sensor_noise: {joint_angle: 0.5 deg, joint_speed_radps: 0.1, position: 1 cm, velocity_mps: 0.05, attitude: 9 deg,
    gyroscope_radps: 0.2}
"""
WITH_UNITS = """\
domain_randomization:
  latency_s: [0, 0.04]
  mass_factor: [0.8, 1.25]
  friction_factor: [0.5, 1.5]
  gravity_mps2: [1.62, 9.81]
  sensor_noise: {joint_angle_rad: 0.008726646259971648, joint_speed_radps: 0.1, position_m: 0.01, velocity_mps: 0.05,
    attitude_rad: 0.15707963267948966, gyroscope_radps: 0.2}
"""


@pytest.mark.parametrize("text", [BARE, WITH_UNITS])
def test_what_a_recipe_says_is_what_its_tasks_vary(tmp_path: Path, text: str) -> None:
    recipe = tiny_recipe(tmp_path, RECIPE + text).recipe
    noise = SensorNoise(
        joint_angle_rad=math.radians(0.5),
        joint_speed_radps=0.1,
        position_m=0.01,
        velocity_mps=0.05,
        attitude_rad=math.radians(9),
        gyroscope_radps=0.2,
    )
    expected = DomainRandomization(
        latency_s=(0.0, 0.04),
        mass_factor=(0.8, 1.25),
        friction_factor=(0.5, 1.5),
        gravity_mps2=(1.62, 9.81),
        sensor_noise=noise,
    )
    assert [recipe.task(phase).domain_randomization for phase in (0, 1)] == [expected, expected]
    fastjsonschema.compile(recipe_schema())(read_tree((RECIPE + text).encode()).data)


def test_nothing_varies_unless_told(tmp_path: Path) -> None:
    assert tiny_recipe(tmp_path).recipe.task(0).domain_randomization == DomainRandomization()
    one = (
        tiny_recipe(tmp_path, RECIPE + "domain_randomization: {gravity_mps2: [1.62, 1.62]}\n")
        .recipe.task(0)
        .domain_randomization
    )
    assert one == DomainRandomization(gravity_mps2=(1.62, 1.62))


WRONG = [
    (
        "latency: [0 ms, 15 ms]",
        "13:23: domain_randomization: latency: 15 ms is not a whole number of the ant's physics steps",
    ),
    ("latency: [0, 40 ms]", "13:34: domain_randomization.latency[0]: 0 has no unit; write 'latency: [0 s, 40 ms]'"),
    ("latency: 20 ms", "13:33: domain_randomization.latency: '20 ms' is not a list"),
    ("latency: [40 ms, 0 ms]", "13:33: domain_randomization.latency: [0.04, 0.0]: the smaller bound comes first"),
    ("latency: [0 ms, 2 s]", "13:40: domain_randomization.latency[1]: must be at most 1 s; got 2 s"),
    ("mass_factor: [0, 1]", "13:38: domain_randomization.mass_factor[0]: must be more than 0; got 0"),
    ("mass_factor: [2, 1]", "13:37: domain_randomization.mass_factor: [2.0, 1.0]: the smaller bound comes first"),
    ("friction_factor: [-1, 1]", "13:42: domain_randomization.friction_factor[0]: must be more than 0; got -1"),
    ("gravity_mps2: [0, .inf]", "13:42: domain_randomization.gravity_mps2[1]: inf is not"),
    ("gravity_mps2: 1.62", "13:38: domain_randomization.gravity_mps2: 1.62 is not a list"),
    ("gravity: [1.62, 9.81]", "13:24: domain_randomization.gravity: unknown key; did you mean 'gravity_mps2'?"),
    (
        "sensor_noise: {joint_angle_rad: -1}",
        "13:56: domain_randomization.sensor_noise.joint_angle_rad: must be at least 0 rad; got -1 rad",
    ),
    (
        "sensor_noise: {gyroscope: 1}",
        "13:39: domain_randomization.sensor_noise.gyroscope: unknown key; did you mean",
    ),
]


@pytest.mark.parametrize(("wrong", "message"), WRONG, ids=[wrong for wrong, _ in WRONG])
def test_what_is_wrong_is_said_with_its_place(tmp_path: Path, wrong: str, message: str) -> None:
    with pytest.raises(RecipeError) as caught:
        tiny_recipe(tmp_path, f"{RECIPE}domain_randomization: {{{wrong}}}\n")
    assert str(caught.value).startswith(f"{tmp_path}/recipe.yaml:{message}")
    assert "\n" not in str(caught.value)
