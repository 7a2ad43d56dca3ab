from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.task.rotations import about, quaternion_of
from tests.task.views import ant_layout, view_of
from waypointctl.errors import InputError
from waypointctl.task.observation import LAYOUTS

FloatArray = NDArray[np.float64]

SIZES = {"state": 25, "state_noise": 29, "state_goal": 29, "egocentric": 31}
LEGS = ("front_left", "back_left", "back_right", "front_right")
JOINTS = [f"{leg}_{joint}" for leg in LEGS for joint in ("hip", "ankle")]


class Scene:
    """A robot somewhere, and where it is to go; every number by its name, computed with rotation matrices."""

    def __init__(self, seed: int, far_m: float = 20.0) -> None:
        rng = np.random.default_rng(seed)
        self.angles = rng.uniform(-0.9, 0.9), rng.uniform(-0.9, 0.9), rng.uniform(-3.1, 3.1)
        self.position = rng.uniform(-10, 10, 3)
        self.velocity, self.rates = rng.normal(size=3), rng.normal(size=3)
        self.joints, self.speeds = rng.uniform(-1, 1, 8), rng.normal(size=8) * 5
        self.goals = rng.uniform(-far_m, far_m, (2, 2)) + self.position[:2]
        self.noise = rng.uniform(-1, 1, 4)

    @property
    def qpos(self) -> FloatArray:
        return np.array([*self.position, *quaternion_of(*self.angles), *self.joints])

    @property
    def qvel(self) -> FloatArray:
        return np.array([*self.velocity, *self.rates, *self.speeds])

    def physical(self) -> Mapping[str, float]:
        """Return every quantity a layout can name, in its unit."""
        roll, pitch, yaw = self.angles
        into_yaw_frame = about(2, yaw).T
        ahead, left, up = into_yaw_frame @ self.velocity
        named = dict(zip(("torso.x", "torso.y", "torso.z"), self.position, strict=True))
        named |= dict(zip(("torso.vx", "torso.vy", "torso.vz"), self.velocity, strict=True))
        named |= {"torso.roll": roll, "torso.pitch": pitch, "torso.yaw": yaw}
        named |= {"torso.v_ahead": ahead, "torso.v_left": left, "torso.v_up": up}
        named |= dict(zip(("torso.rate_x", "torso.rate_y", "torso.rate_z"), self.rates, strict=True))
        named |= {f"{name}.angle": angle for name, angle in zip(JOINTS, self.joints, strict=True)}
        named |= {f"{name}.speed": speed for name, speed in zip(JOINTS, self.speeds, strict=True)}
        named |= {f"noise.{i}": value for i, value in enumerate(self.noise)}
        for name, goal in zip(("current", "next"), self.goals, strict=True):
            offset = np.array([*(goal - self.position[:2]), 0.0])
            distance = math.hypot(offset[0], offset[1])
            seen = into_yaw_frame @ offset / distance
            named |= {f"{name}.x": goal[0], f"{name}.y": goal[1]}
            named |= {f"{name}.ahead": seen[0], f"{name}.left": seen[1], f"{name}.distance": min(distance, 5.0)}
        return named


def observe(name: str, *scenes: Scene) -> FloatArray:
    qpos, qvel = np.stack([s.qpos for s in scenes]), np.stack([s.qvel for s in scenes])
    goals, noise = np.stack([s.goals for s in scenes]), np.stack([s.noise for s in scenes])
    return ant_layout(name).observe(view_of(qpos, qvel, goals, noise=noise))


@pytest.mark.parametrize("name", LAYOUTS)
@pytest.mark.parametrize("far_m", [2.0, 20.0])
def test_each_number_is_the_named_quantity_times_its_scale(name: str, far_m: float) -> None:
    scenes = [Scene(seed, far_m) for seed in range(50)]
    observation = observe(name, *scenes)
    assert observation.shape == (50, SIZES[name])
    for row, scene in zip(observation, scenes, strict=True):
        quantities = scene.physical()
        expected = [quantities[component] * scale for component, _, scale in ant_layout(name).components]
        np.testing.assert_allclose(row, expected, atol=1e-9)


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_layout_names_every_number_once_with_its_unit(name: str) -> None:
    components = ant_layout(name).components
    assert ant_layout(name).size == len(components) == SIZES[name]
    assert len({component for component, _, _ in components}) == len(components)
    assert {unit for _, unit, _ in components} <= {"m", "m/s", "rad", "rad/s", "1"}


def test_the_papers_layouts_begin_with_the_same_25_numbers_in_the_papers_order() -> None:
    names = [component for component, _, _ in ant_layout("state").components]
    assert names[:16] == [f"{joint}.angle" for joint in JOINTS] + [f"{joint}.speed" for joint in JOINTS]
    assert names[16:] == [f"torso.{part}" for part in ("x", "y", "z", "vx", "vy", "vz", "roll", "pitch", "yaw")]
    for other in ("state_noise", "state_goal"):
        assert ant_layout(other).components[:25] == ant_layout("state").components
    goals = [component for component, _, _ in ant_layout("state_goal").components[25:]]
    assert goals == ["current.x", "current.y", "next.x", "next.y"]


@given(st.integers(0, 10_000), st.floats(-3.1, 3.1), st.tuples(*[st.floats(-100, 100)] * 2))
@settings(max_examples=150, deadline=None)
def test_egocentric_looks_the_same_from_everywhere_in_every_direction(
    seed: int, turn: float, move: tuple[float, float]
) -> None:
    here, there = Scene(seed), Scene(seed)
    turned = about(2, turn)
    there.angles = here.angles[0], here.angles[1], here.angles[2] + turn
    there.velocity = turned @ here.velocity
    there.position = turned @ here.position + [*move, 0.0]
    there.goals = here.goals @ turned[:2, :2].T + move
    np.testing.assert_allclose(observe("egocentric", there), observe("egocentric", here), atol=1e-8)


def test_a_goal_under_the_robot_has_no_direction_and_is_still_a_number() -> None:
    scene = Scene(0)
    scene.goals = np.tile(scene.position[:2], (2, 1))
    assert observe("egocentric", scene)[0, :6].tolist() == [0.0] * 6


def test_a_goal_farther_than_five_metres_looks_five_metres_away() -> None:
    near, far = Scene(1), Scene(1)
    direction = np.array([0.6, 0.8])
    near.goals = near.position[:2] + np.outer([5.0, 5.0], direction)
    far.goals = far.position[:2] + np.outer([6.0, 600.0], direction)
    np.testing.assert_allclose(observe("egocentric", far), observe("egocentric", near), atol=1e-9)


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_robots_row_does_not_depend_on_the_others(name: str) -> None:
    scenes = [Scene(seed) for seed in range(5)]
    together = observe(name, *scenes)
    for row, scene in zip(together, scenes, strict=True):
        np.testing.assert_array_equal(observe(name, scene)[0], row)


def test_an_unknown_layout_is_refused_with_those_there_are() -> None:
    message = "unknown observation layout 'ego'; available: state, state_noise, state_goal, egocentric"
    with pytest.raises(InputError, match=message):
        ant_layout("ego")
