"""The world as it is drawn: the robot's own model, with a sky and a ground without end."""

from __future__ import annotations

from typing import Final

import mujoco

from waypointctl.sim.model import RobotModel

WIDTH: Final = 640  # of a picture [pixels]
HEIGHT: Final = 480
FOVY_DEG: Final = 60.0  # of the camera, from the lower edge of the picture to the upper one
FAR_M: Final = 120.0  # nothing is drawn beyond
_NEAR_M: Final = 0.02
_ZENITH: Final = (0.34, 0.55, 0.80)
_HORIZON: Final = (0.86, 0.90, 0.94)  # where the ground fades into the sky
_CHECK_M: Final = 1.0  # side of the ground's checks


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
