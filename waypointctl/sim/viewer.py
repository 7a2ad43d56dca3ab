"""MuJoCo's own viewer, in a window: where there is a display, and a clear message where there is none."""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections.abc import Callable, Iterable

import mujoco
import numpy as np

from waypointctl.errors import InputError
from waypointctl.sim.camera import FOLLOW_ELEVATION_DEG, FOLLOW_M, POST_COLOUR, POST_M, POST_RADIUS_M, Marker, scenery
from waypointctl.sim.model import FloatArray, RobotModel

_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")
_HINT = "Run it on a desktop, or give render_mode='rgb_array', which needs no display."


class Viewer:
    """A window that shows a robot at its own speed. It draws data of its own: the physics never notices."""

    def __init__(self, robot: RobotModel, clock: Callable[[], float] = time.monotonic) -> None:
        """Open the window; `close` it at the end.

        Raises:
            InputError: there is no display.
        """
        _refuse_missing_display()
        import mujoco.viewer

        self._model = scenery(robot)
        self._data = mujoco.MjData(self._model)
        self._handle = mujoco.viewer.launch_passive(self._model, self._data, show_left_ui=False, show_right_ui=False)
        self._clock = clock
        self._next_s = 0.0
        with self._handle.lock():
            camera = self._handle.cam
            camera.distance, camera.azimuth, camera.elevation = FOLLOW_M, 90.0, FOLLOW_ELEVATION_DEG

    def mark(self, markers: Iterable[Marker]) -> None:
        """Mark places with posts, and no others."""
        scene = self._handle.user_scn
        with self._handle.lock():
            scene.ngeom = 0
            for marker in list(markers)[: scene.maxgeom]:
                _post(scene.geoms[scene.ngeom], marker)
                scene.ngeom += 1

    def show(self, qpos: FloatArray, period_s: float) -> None:
        """Show the robot at qpos (nq,), `period_s` after the last time; a closed window shows nothing."""
        if not self._handle.is_running():
            return
        with self._handle.lock():
            self._data.qpos[:] = qpos
            mujoco.mj_forward(self._model, self._data)
            self._handle.cam.lookat[:] = qpos[:3]
        self._handle.sync()
        now_s = self._clock()
        self._next_s = max(self._next_s + period_s, now_s)
        time.sleep(self._next_s - now_s)

    def close(self) -> None:
        """Close the window."""
        self._handle.close()


def _refuse_missing_display() -> None:
    """Refuse to open a window that cannot be: MuJoCo would end the whole process."""
    if sys.platform.startswith("linux") and not any(os.environ.get(name) for name in _DISPLAYS):
        raise InputError(f"a window needs a display, and neither {' nor '.join(_DISPLAYS)} is set", hint=_HINT)
    import glfw

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # GLFW warns of what makes it fail
        opened = glfw.init()
    if not opened:
        display = ", ".join(f"{name}={os.environ[name]}" for name in _DISPLAYS if os.environ.get(name))
        raise InputError(f"a window cannot be opened on {display or 'this display'}", hint=_HINT)


def _post(geom: mujoco.MjvGeom, marker: Marker) -> None:
    size, place = np.array([POST_RADIUS_M, POST_M / 2, 0.0]), np.array([marker.x_m, marker.y_m, POST_M / 2])
    colour = np.array(POST_COLOUR, np.float32)
    mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_CYLINDER, size, place, np.eye(3).ravel(), colour)
