"""What a Gymnasium environment renders: frames, or a window."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, Literal, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.robots.robot import Robot

if TYPE_CHECKING:
    from waypointctl.sim.camera import Camera, Marker
    from waypointctl.sim.viewer import Viewer

FloatArray = NDArray[np.float64]
RenderMode: TypeAlias = Literal["human", "rgb_array"]

RENDER_MODES: Final = ("human", "rgb_array")


def render_mode_of(mode: str | None) -> RenderMode | None:
    """Return the render mode if it is known.

    Raises:
        InputError: the mode is unknown.
    """
    if mode is not None and mode not in RENDER_MODES:
        raise InputError(f"unknown render_mode {mode!r}; allowed: {', '.join(RENDER_MODES)}, None")
    return cast("RenderMode | None", mode)


class Rendering:
    """Draws one robot and the waypoints that are ahead of it. The renderer is created at the first frame."""

    def __init__(self, robot: Robot, mode: RenderMode) -> None:
        """Draw in a mode. A window is opened at once; without a display there is a warning and no window."""
        self._robot = robot
        self._period_s = robot.control_period_ns / 1e9
        self._camera: Camera | None = None
        self._viewer: Viewer | None = None
        if mode == "human":
            from waypointctl.sim.viewer import Viewer

            try:
                self._viewer = Viewer(robot)
            except InputError as error:  # no reason to end a training; Gymnasium's checker makes every mode
                warnings.warn(f"no window is shown: {error}", stacklevel=3)

    def show(self, qpos: FloatArray, ahead: Sequence[FloatArray]) -> None:
        """Show the robot at qpos (nq,), and the waypoints ahead, each (2,) [m], where there is a window."""
        if self._viewer is not None:
            self._viewer.mark(_markers(ahead))
            self._viewer.show(qpos, self._period_s)

    def frame(self, qpos: FloatArray, ahead: Sequence[FloatArray]) -> NDArray[np.uint8]:
        """Return the picture (480, 640, 3) uint8 of the robot at qpos (nq,), the first row on top.

        Raises:
            NoRendering: no OpenGL renderer is available.
        """
        from waypointctl.sim.camera import Camera, follow

        if self._camera is None:
            self._camera = Camera(self._robot, (), follow)
        self._camera.markers = tuple(_markers(ahead))
        return self._camera.take(qpos)

    def close(self) -> None:
        """Release the renderer, and close the window."""
        for drawing in (self._camera, self._viewer):
            if drawing is not None:
                drawing.close()
        self._camera = self._viewer = None


def _markers(ahead: Sequence[FloatArray]) -> list[Marker]:
    from waypointctl.sim.camera import Marker

    return [Marker("", float(x_m), float(y_m)) for x_m, y_m in ahead]
