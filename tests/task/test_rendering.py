from __future__ import annotations

import contextlib
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import mujoco.viewer
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tests.drawing import require_rendering
from waypointctl.errors import InputError
from waypointctl.robots.load import load_robot
from waypointctl.sim import viewer
from waypointctl.sim.camera import Marker
from waypointctl.task.env import RENDER_MODES, WaypointEnv
from waypointctl.task.register import ENV_ID

AHEAD = {"waypoints": [[2, 1], [4, 0]], "position_m": [0, 0], "heading_rad": 0.0}
STILL = np.zeros(8, np.float32)


@pytest.fixture
def drawing() -> None:
    """Skip where nothing can draw."""
    require_rendering()


@pytest.mark.usefixtures("drawing")
def test_a_frame_is_a_picture_of_where_the_robot_and_its_waypoints_are() -> None:
    env = WaypointEnv(render_mode="rgb_array")
    env.reset(seed=0, options=AHEAD)
    first = env.render()
    assert first is not None
    assert first.shape == (480, 640, 3)
    assert first.dtype == np.uint8
    np.testing.assert_array_equal(first, env.render())  # drawing changes nothing
    env.reset(seed=0, options=AHEAD | {"waypoints": [[2, 1]]})
    other = env.render()
    assert other is not None
    assert (first != other).any()  # a post less
    env.step(np.ones(8, np.float32))
    moved = env.render()
    assert moved is not None
    assert (moved != other).any()
    env.close()


@pytest.mark.usefixtures("drawing")
def test_drawing_changes_no_step() -> None:
    seen = []
    for mode in (None, "rgb_array"):
        env = WaypointEnv(render_mode=mode)
        env.reset(seed=3)
        for _ in range(20):
            step = env.step(np.full(8, 0.5, np.float32))
            if mode:
                env.render()
        seen.append(step[0])
        env.close()
    np.testing.assert_array_equal(seen[0], seen[1])


@pytest.mark.usefixtures("drawing")
def test_gymnasium_makes_and_records_it(tmp_path: Path) -> None:
    pytest.importorskip("moviepy", reason="RecordVideo writes with moviepy")
    env: Any = gymnasium.wrappers.RecordVideo(gymnasium.make(ENV_ID, render_mode="rgb_array"), str(tmp_path / "videos"))
    env.reset(seed=0)
    for _ in range(3):
        env.step(STILL)
    env.close()
    (video,) = tmp_path.glob("videos/*.mp4")
    assert video.stat().st_size > 0


@pytest.mark.usefixtures("drawing")
def test_gymnasiums_recorder_of_frames_gets_one_a_step() -> None:
    made = gymnasium.make(ENV_ID, render_mode="rgb_array")
    env = gymnasium.wrappers.RenderCollection(made, pop_frames=False)
    env.reset(seed=0)
    for _ in range(3):
        env.step(STILL)
    frames: Any = env.render()
    assert len(frames) == 4
    assert all(frame.shape == (480, 640, 3) and frame.dtype == np.uint8 for frame in frames)
    env.close()


def test_the_metadata_are_what_gymnasium_reads() -> None:
    env = gymnasium.make(ENV_ID)
    assert env.metadata["render_modes"] == list(RENDER_MODES) == ["human", "rgb_array"]
    assert env.metadata["render_fps"] == 1e9 / load_robot("ant").control_period_ns
    assert env.unwrapped.render_mode is None


def test_without_a_render_mode_nothing_is_rendered_and_a_warning_says_why() -> None:
    env = WaypointEnv()
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="use 'rgb_array' or 'human'"):
        assert env.render() is None


@pytest.mark.parametrize("mode", ["ansi", "rgb", ""])
def test_a_render_mode_that_there_is_not_is_refused(mode: str) -> None:
    with pytest.raises(InputError, match=f"unknown render_mode '{mode}'; allowed: human, rgb_array, None"):
        WaypointEnv(render_mode=mode)


def test_a_window_without_a_display_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.warns(UserWarning, match=r"no window is shown: a window needs a display, and neither DISPLAY nor WAY"):
        env = WaypointEnv(render_mode="human")
    env.reset(seed=0)
    assert env.render() is None
    env.close()


@pytest.mark.usefixtures("drawing")
@pytest.mark.filterwarnings("ignore:no window is shown")
def test_gymnasiums_checker_has_no_complaint_about_any_render_mode() -> None:
    check_env(gymnasium.make(ENV_ID).unwrapped)


def test_a_display_that_does_not_answer_is_a_warning() -> None:
    code = "from waypointctl.task.env import WaypointEnv; WaypointEnv(render_mode='human')"
    environment = {"DISPLAY": ":4711", "PATH": "", "PYTHONPATH": ":".join(sys.path)}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
    assert done.returncode == 0
    assert "no window is shown: a window cannot be opened on DISPLAY=:4711" in done.stderr


def test_a_window_shows_every_step_at_the_robots_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[tuple[float, int]] = []

    class Window:
        def __init__(self, robot: object) -> None:
            self.posts = 0

        def mark(self, markers: list[object]) -> None:
            self.posts = len(markers)

        def show(self, qpos: Any, period_s: float) -> None:
            shown.append((period_s, self.posts))

        def close(self) -> None:
            shown.clear()

    monkeypatch.setattr(viewer, "Viewer", Window)
    env = WaypointEnv(render_mode="human")
    env.reset(seed=0, options=AHEAD)
    env.step(STILL)
    assert env.render() is None
    assert shown == [(0.02, 2)] * 2
    env.close()
    assert shown == []


def test_a_window_keeps_the_robots_time_and_marks_the_waypoints(monkeypatch: pytest.MonkeyPatch) -> None:
    slept: list[float] = []
    scene = mujoco.MjvScene(load_robot("ant").model, 100)
    handle = SimpleNamespace(
        lock=contextlib.nullcontext,
        cam=mujoco.MjvCamera(),
        user_scn=scene,
        is_running=lambda: True,
        sync=lambda: None,
        close=lambda: None,
    )
    monkeypatch.setattr(mujoco.viewer, "launch_passive", lambda *_, **__: handle)
    monkeypatch.setattr(viewer, "_refuse_missing_display", lambda: None)
    monkeypatch.setattr(time, "sleep", slept.append)
    window = viewer.Viewer(load_robot("ant"), clock=iter([5.0, 5.005, 9.0]).__next__)
    qpos = np.zeros(15)
    qpos[:4] = 3.0, 2.0, 0.5, 1.0
    for _ in range(3):
        window.show(qpos, 0.02)
    assert slept == pytest.approx([0.0, 0.015, 0.0])  # at once, 20 ms after the first, and late
    assert handle.cam.lookat.tolist() == [3.0, 2.0, 0.5]
    window.mark([Marker("", 1.0, 2.0), Marker("", 3.0, 4.0)])
    assert scene.ngeom == 2
    assert scene.geoms[1].pos.tolist() == pytest.approx([3.0, 4.0, 0.6])
