"""The physical world: robots and stepping one or many of them."""

import os
from typing import Final

_SAFE: Final = ("", "egl", "glfw", "disable", "disabled", "off", "false", "0")


def _import_mujoco() -> None:
    """Import MuJoCo without an OpenGL: it opens the requested one at once, and fails where there is none."""
    requested = os.environ["MUJOCO_GL"]
    os.environ["MUJOCO_GL"] = "disable"
    try:
        import mujoco  # noqa: F401
    finally:
        os.environ["MUJOCO_GL"] = requested


if os.environ.get("MUJOCO_GL", "").lower() not in _SAFE:
    _import_mujoco()  # offscreen.py reports the problem when a picture is to be taken
