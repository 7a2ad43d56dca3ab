from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.sim.bare import BareWorld, random_start
from waypointctl.robots.load import load_robot
from waypointctl.sim import stepping
from waypointctl.sim.stepping import RobotBatch

ROBOTS = 7


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_every_robot_goes_as_it_goes_in_a_bare_mj_step_loop(threads: int) -> None:
    rng = np.random.default_rng(threads)
    batch = RobotBatch(load_robot("ant"), ROBOTS, threads)
    worlds = [BareWorld() for _ in range(ROBOTS)]
    for step in range(400):
        fresh = np.flatnonzero(rng.random(ROBOTS) < 0.02) if step else np.arange(ROBOTS)
        starts = [random_start(rng) for _ in fresh]
        if starts:
            batch.place(fresh, np.stack([qpos for qpos, _ in starts]), np.stack([qvel for _, qvel in starts]))
        for robot, start in zip(fresh, starts, strict=True):
            worlds[robot].place(*start)
        applied = rng.uniform(-1.0, 1.0, (ROBOTS, 8))
        batch.step(applied)
        for i, world in enumerate(worlds):
            world.step(applied[i])
            np.testing.assert_array_equal(batch.integration[i], world.integration)
            np.testing.assert_array_equal(batch.qpos[i], world.data.qpos)
            np.testing.assert_array_equal(batch.qvel[i], world.data.qvel)


def test_a_robot_that_is_placed_leaves_the_others_alone() -> None:
    rng = np.random.default_rng(0)
    batch = RobotBatch(load_robot("ant"), 3)
    for i in range(3):
        qpos, qvel = random_start(rng)
        batch.place(np.array([i]), qpos[np.newaxis], qvel[np.newaxis])
    batch.step(np.zeros((3, 8)))
    before = batch.integration.copy()
    qpos, qvel = random_start(rng)
    batch.place(np.array([1]), qpos[np.newaxis], qvel[np.newaxis])
    np.testing.assert_array_equal(batch.integration[[0, 2]], before[[0, 2]])
    assert not np.array_equal(batch.integration[1], before[1])


def test_a_step_moves_only_the_robots_that_are_named() -> None:
    rng = np.random.default_rng(1)
    batch = RobotBatch(load_robot("ant"), 4)
    worlds = [BareWorld() for _ in range(4)]
    for i, world in enumerate(worlds):
        qpos, qvel = random_start(rng)
        batch.place(np.array([i]), qpos[np.newaxis], qvel[np.newaxis])
        world.place(qpos, qvel)
    for stepped in ([True, False, True, True], [False, False, True, False], None):
        batch.stepped = None if stepped is None else np.array(stepped)
        applied = rng.uniform(-1.0, 1.0, (4, 8))
        batch.step(applied)
        for i, world in enumerate(worlds):
            if stepped is None or stepped[i]:
                world.step(applied[i])
            np.testing.assert_array_equal(batch.qpos[i], world.data.qpos)
            np.testing.assert_array_equal(batch.qvel[i], world.data.qvel)


@pytest.mark.parametrize(
    ("cores", "quota", "expected"),
    [
        (1, None, 1),
        (2, None, 2),
        (64, None, 8),
        (64, "max 100000", 8),
        (64, "200000 100000", 2),
        (4, "50000 100000", 1),
        (4, "broken", 4),
    ],
)
def test_the_default_threads_are_the_cores_that_may_be_used(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, cores: int, quota: str | None, expected: int
) -> None:
    monkeypatch.setattr("os.sched_getaffinity", lambda _: set(range(cores)))
    monkeypatch.setattr(stepping, "_QUOTA", tmp_path / "cpu.max")
    if quota is not None:
        (tmp_path / "cpu.max").write_text(f"{quota}\n")
    assert stepping.default_threads() == expected
