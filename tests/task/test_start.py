from __future__ import annotations

import math

import numpy as np
import pytest

from waypointctl.mission.fields import Start
from waypointctl.robots.load import load_robot
from waypointctl.task.config import draw_start


def test_stands_where_it_is_told_within_the_spread() -> None:
    robot, rng = load_robot("ant"), np.random.default_rng(0)
    start = Start(position_m=(3.0, -4.0), heading_deg=math.degrees(1.0), joint_spread_rad=0.2, speed_spread=0.3)
    draws = [draw_start(start, robot, rng) for _ in range(500)]
    qpos, qvel = (np.stack(part) for part in zip(*draws, strict=True))
    assert qpos.shape == (500, 15)
    assert qvel.shape == (500, 14)
    np.testing.assert_array_equal(qpos[:, :3], np.tile([3.0, -4.0, robot.nominal_height_m], (500, 1)))
    np.testing.assert_allclose(qpos[:, 3:7], np.tile([np.cos(0.5), 0.0, 0.0, np.sin(0.5)], (500, 1)))
    off = np.abs(qpos[:, 7:] - robot.nominal)
    assert off.max() <= 0.2
    assert off.max(axis=0).min() > 0.19, "every joint uses its whole spread"
    assert np.abs(qvel).max() <= 0.3
    assert np.abs(qvel).max(axis=0).min() > 0.29


def test_a_heading_that_is_not_given_is_drawn_from_the_whole_circle() -> None:
    robot, rng = load_robot("ant"), np.random.default_rng(1)
    qpos = np.stack([draw_start(Start(random_heading=True), robot, rng)[0] for _ in range(800)])
    np.testing.assert_allclose(np.linalg.norm(qpos[:, 3:7], axis=1), 1.0)
    headings = 2 * np.arctan2(qpos[:, 6], qpos[:, 3])
    counts, _ = np.histogram(headings, bins=8, range=(-np.pi, np.pi))
    assert counts.min() > 70


def test_without_spread_every_start_is_the_stance() -> None:
    robot = load_robot("ant")
    qpos, qvel = draw_start(Start(joint_spread_rad=0.0, speed_spread=0.0), robot, np.random.default_rng(2))
    np.testing.assert_array_equal(qpos[7:], robot.nominal)
    assert not qvel.any()
    assert qpos[3:7] == pytest.approx([1.0, 0.0, 0.0, 0.0])
