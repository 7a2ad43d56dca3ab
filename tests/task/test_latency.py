from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from waypointctl.task.randomized_robots import ActuatorLatency

FloatArray = NDArray[np.float64]

JOINTS = 3


class Motors:
    """Remembers what the motors were told in each physics step."""

    def __init__(self) -> None:
        self.held: list[FloatArray] = []

    def step(self, applied: FloatArray) -> None:
        self.held.append(applied.copy())


def numbered(robots: int, step: int) -> FloatArray:
    """Return actions (robots, JOINTS) that are different for each robot, joint and control step, and never 0."""
    return step + 1 + 0.1 * np.arange(robots)[:, np.newaxis] + 0.01 * np.arange(JOINTS)


def expected(physics_step: int, latency: int, substeps: int, robot: int) -> FloatArray:
    """Return what a plain queue of one action each physics step would give the motors."""
    queue = [np.zeros(JOINTS)] * latency
    for step in range(physics_step + 1):
        queue.append(numbered(robot + 1, step // substeps)[robot])
    return queue[physics_step]


@pytest.mark.parametrize("substeps", [1, 2, 3, 4])
def test_each_robots_motors_hold_what_was_commanded_exactly_so_many_physics_steps_before(substeps: int) -> None:
    robots = 6  # with latencies of 0 to 5 physics steps
    latency, motors = ActuatorLatency(robots, JOINTS, substeps, robots - 1), Motors()
    latency.steps[:] = np.arange(robots)
    for step in range(8):
        at_the_end = latency.step(numbered(robots, step), motors.step)
        np.testing.assert_array_equal(at_the_end, motors.held[-1])
    assert len(motors.held) == 8 * substeps
    for physics_step, held in enumerate(motors.held):
        for robot in range(robots):
            np.testing.assert_array_equal(held[robot], expected(physics_step, robot, substeps, robot))


def test_an_action_may_take_effect_in_the_middle_of_a_control_period() -> None:
    latency, motors = ActuatorLatency(1, 1, 2, 4), Motors()
    latency.steps[:] = 1
    for action in (0.5, -0.5):
        latency.step(np.array([[action]]), motors.step)
    assert [float(held[0, 0]) for held in motors.held] == [0.0, 0.5, 0.5, -0.5]


def test_motors_are_off_until_the_first_action_of_an_episode_has_arrived() -> None:
    latency, motors = ActuatorLatency(2, 1, 2, 4), Motors()
    latency.steps[:] = 4
    for _ in range(4):
        latency.step(np.ones((2, 1)), motors.step)
    latency.switch_off(np.array([1]))
    for _ in range(3):
        latency.step(np.ones((2, 1)), motors.step)
    held = np.array(motors.held)[:, :, 0]
    np.testing.assert_array_equal(held[:, 0], [0, 0, 0, 0] + [1] * 10)
    np.testing.assert_array_equal(held[:, 1], [0, 0, 0, 0] + [1] * 4 + [0] * 4 + [1] * 2)


def test_every_action_is_what_the_motors_hold_at_the_end_of_one_control_period_whatever_the_latency() -> None:
    latency, motors = ActuatorLatency(5, 1, 2, 4), Motors()
    latency.steps[:] = np.arange(5)
    ends = np.array([latency.step(np.full((5, 1), step + 1.0), motors.step)[:, 0] for step in range(10)])
    for robot in range(5):
        late = robot // 2
        np.testing.assert_array_equal(ends[:, robot], [*[0.0] * late, *range(1, 11 - late)])
