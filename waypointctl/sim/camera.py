"""Pictures of a robot in its world, from its own camera and from one that follows it; the world as it is drawn."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Final, TypeAlias

import mujoco
import numpy as np
from numpy.typing import NDArray

from waypointctl.sim.model import CameraMount, FloatArray, RobotModel
from waypointctl.sim.offscreen import NoRendering, OffscreenContext

WIDTH: Final = 640  # of a picture [pixels]
HEIGHT: Final = 480
FOVY_DEG: Final = 60.0  # of the camera, from the lower edge of the picture to the upper one
FAR_M: Final = 120.0  # nothing is drawn beyond
_NEAR_M: Final = 0.02
_ZENITH: Final = (0.34, 0.55, 0.80)
_HORIZON: Final = (0.86, 0.90, 0.94)  # where the ground fades into the sky
_CHECK_M: Final = 1.0  # side of the ground's checks

Pixels = NDArray[np.uint8]
Viewpoint: TypeAlias = Callable[[FloatArray], mujoco.MjvCamera]  # the camera at qpos (nq,)
FOLLOW_M: Final = 7.0  # the camera that follows, from the base
FOLLOW_ELEVATION_DEG: Final = -30.0
POST_M: Final = 1.2  # height of a waypoint's marker
POST_COLOUR: Final = (1.0, 0.5, 0.05, 1.0)
POST_RADIUS_M: Final = 0.03
_KNOB_RADIUS_M: Final = 0.08
_FOOT_RADIUS_M: Final = 0.2
_FOOT_HEIGHT_M: Final = 0.01
_CLEAR_M: Final = 2.0  # a post nearer to the camera would hide the view: only its foot is drawn
_NAMED_M: Final = 25.0  # names of what is farther away would lie on each other
_MOST_MARKERS: Final = 200  # the nearest
_GLOW: Final = 0.4  # of the markers, or those between camera and sun are black


def scenery(robot: RobotModel) -> mujoco.MjModel:
    """Return a model with the robot's joints in the robot's order, to be looked at and never stepped.

    It is compiled from the source anew: the model that flies, and its hash, know nothing of a sky.
    """
    spec = mujoco.MjSpec.from_string(robot.source.xml, assets=dict(robot.source.assets))
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=_ZENITH,
        rgb2=_HORIZON,
        width=256,
        height=256,
    )
    for geom in spec.geoms:
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
            geom.size = [0.0, 0.0, 1.0]  # without end, as the physics has it
    for material in spec.materials:
        material.texuniform = True
        material.texrepeat = [0.5 / _CHECK_M] * 2  # the checker's texture has two checks a side
    _light(spec)
    model = spec.compile()
    # In MuJoCo's units these are multiples of the model's extent, which a plane without end leaves to the robot.
    model.stat.extent = 1.0
    return model


def _light(spec: mujoco.MjSpec) -> None:
    visual = spec.visual
    visual.headlight.ambient = [0.35] * 3
    visual.headlight.diffuse = [0.25] * 3
    visual.headlight.specular = [0.0] * 3
    visual.rgba.haze = [*_HORIZON, 1.0]
    visual.map.haze = 0.4
    visual.map.znear, visual.map.zfar = _NEAR_M, FAR_M
    visual.global_.fovy = FOVY_DEG
    visual.global_.offwidth, visual.global_.offheight = WIDTH, HEIGHT


@dataclass(frozen=True, slots=True)
class Marker:
    """A place that is marked with a post."""

    name: str
    x_m: float
    y_m: float


class Camera:
    """Draws a robot in its world. It computes on data of its own: the physics never notices.

    Attributes:
        markers: the places that are marked.
        renderer: what draws; where it is the same, a picture is the same to the last bit.
    """

    def __init__(self, robot: RobotModel, markers: Iterable[Marker], view: Viewpoint) -> None:
        """Set up the scene; `close` it at the end.

        Args:
            robot: what is drawn.
            markers: places to mark with a post.
            view: where the camera is.

        Raises:
            NoRendering: no renderer is available.
        """
        self.markers = tuple(markers)
        self._view = view
        self._context = OffscreenContext(WIDTH, HEIGHT)
        self.renderer = f"{self._context.renderer}, MuJoCo {mujoco.__version__}"
        self._model = scenery(robot)
        self._data = mujoco.MjData(self._model)
        try:
            self._drawing = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._drawing)
        except mujoco.FatalError as error:
            self._context.close()
            raise NoRendering(f"{self.renderer} cannot draw: {error}") from error
        self._scene = mujoco.MjvScene(self._model, self._model.ngeom + 3 * _MOST_MARKERS + 10)

    def take(self, qpos: FloatArray) -> Pixels:
        """Return the picture at qpos (nq,): (480, 640, 3), red green blue, the first row on top."""
        data, scene = self._data, self._scene
        self._context.make_current()
        data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_camlight(self._model, data)
        view, seen = self._view(qpos), mujoco.mjtCatBit.mjCAT_ALL
        # A ground without end is laid around the camera that the scene has, which would be the last picture's.
        mujoco.mjv_updateCamera(self._model, data, view, scene)
        mujoco.mjv_updateScene(self._model, data, mujoco.MjvOption(), mujoco.MjvPerturb(), view, seen, scene)
        scene.flags[mujoco.mjtRndFlag.mjRND_HAZE] = True
        scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = False  # speckled on a ground without end, and the dearest part
        self._mark(_eye(view))
        frame = mujoco.MjrRect(0, 0, WIDTH, HEIGHT)
        mujoco.mjr_render(frame, scene, self._drawing)
        pixels = np.empty((HEIGHT, WIDTH, 3), np.uint8)
        mujoco.mjr_readPixels(pixels, None, frame, self._drawing)
        return np.ascontiguousarray(pixels[::-1])

    def close(self) -> None:
        """Give the drawing's memory back."""
        self._context.make_current()
        self._drawing.free()
        self._context.close()

    def _mark(self, camera: FloatArray) -> None:
        """Set a marker at each place near the camera (3,) [m]."""
        far = [(math.hypot(it.x_m - camera[0], it.y_m - camera[1]), it) for it in self.markers]
        near = sorted((pair for pair in far if pair[0] < FAR_M), key=lambda pair: pair[0])
        for distance_m, it in near[:_MOST_MARKERS]:
            cylinder = mujoco.mjtGeom.mjGEOM_CYLINDER
            self._shape(cylinder, (_FOOT_RADIUS_M, _FOOT_HEIGHT_M, 0), (it.x_m, it.y_m, _FOOT_HEIGHT_M))
            if distance_m < _CLEAR_M:
                continue
            self._shape(cylinder, (POST_RADIUS_M, POST_M / 2, 0), (it.x_m, it.y_m, POST_M / 2))
            name = it.name if distance_m < _NAMED_M else ""
            self._shape(mujoco.mjtGeom.mjGEOM_SPHERE, (_KNOB_RADIUS_M,) * 3, (it.x_m, it.y_m, POST_M), name)

    def _shape(
        self, kind: mujoco.mjtGeom, size: tuple[float, ...], position: tuple[float, float, float], name: str = ""
    ) -> None:
        geom = self._scene.geoms[self._scene.ngeom]
        upright = np.eye(3).ravel()
        mujoco.mjv_initGeom(geom, kind, np.array(size), np.array(position), upright, np.array(POST_COLOUR, np.float32))
        geom.category = int(mujoco.mjtCatBit.mjCAT_DECOR)
        geom.emission = _GLOW
        geom.label = name.encode("ascii", "replace").decode()[:60]  # MuJoCo's font has no others, and labels hold 99
        self._scene.ngeom += 1


class MountedCamera(Camera):
    """Draws what a robot's own camera sees."""

    def __init__(self, robot: RobotModel, markers: Iterable[Marker]) -> None:
        """Set up the scene; `close` it at the end.

        Raises:
            NoRendering: no renderer is available.
        """
        super().__init__(robot, markers, partial(viewpoint, robot.camera))


def follow(qpos: FloatArray) -> mujoco.MjvCamera:
    """Return a camera that looks at the robot at qpos (nq,) from the side, always from the same direction."""
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = qpos[:3]
    camera.distance, camera.azimuth, camera.elevation = FOLLOW_M, 90.0, FOLLOW_ELEVATION_DEG
    return camera


def _eye(view: mujoco.MjvCamera) -> FloatArray:
    """Return the position of a camera (3,) [m]."""
    azimuth, elevation = math.radians(view.azimuth), math.radians(view.elevation)
    level = math.cos(elevation)
    forward = np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation)])
    return np.asarray(view.lookat - view.distance * forward)


def viewpoint(mount: CameraMount, qpos: FloatArray) -> mujoco.MjvCamera:
    """Return a mounted camera at qpos (nq,)."""
    w, x, y, z = qpos[3:7].tolist()
    heading = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    ahead, left, up = mount.position_m
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = qpos[:3] + np.array([math.cos(heading), math.sin(heading), 0.0]) * ahead
    camera.lookat[:] += np.array([-math.sin(heading) * left, math.cos(heading) * left, up])
    camera.distance = 0.0  # the camera is at its own look-at point
    camera.azimuth, camera.elevation = math.degrees(heading), mount.pitch_deg
    return camera
