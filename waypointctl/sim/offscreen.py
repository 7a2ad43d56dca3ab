"""OpenGL without a screen, and why there is none where there is none."""

from __future__ import annotations

import ctypes
import importlib
import os
from typing import Any, Final

from waypointctl.errors import InputError

VARIABLE: Final = "MUJOCO_GL"  # MuJoCo's own: which OpenGL is to be used
_OFF: Final = ("disable", "disabled", "off", "false", "0")
_LIBRARIES: Final = {
    "egl": ("libEGL.so.1", "libEGL.so"),
    "osmesa": ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"),
}
_ALLOWED: Final = ("egl", "osmesa", "glfw", "disable")
_INSTALL: Final = "Install one, such as with: apt-get install libegl1 libgl1-mesa-dri"


class NoRendering(InputError):
    """There is nothing here that could draw."""


class OffscreenContext:
    """An OpenGL context; it is current until it is closed.

    Attributes:
        renderer: what draws, such as "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5 Mesa 22.3.6".
    """

    def __init__(self, width: int, height: int) -> None:
        """Make a context for pictures of at most this size [pixels].

        Raises:
            NoRendering: there is no OpenGL, or the environment says that it is not to be used.
        """
        backend = _backend(os.environ.get(VARIABLE, "").strip().lower())
        try:
            # Each of mujoco's modules picks PyOpenGL's platform for the whole process: import the one that is used.
            self._context: Any = importlib.import_module(f"mujoco.{backend}").GLContext(width, height)
            self._context.make_current()
            self.renderer = _renderer()
        # A driver that is missing or broken shows as whatever its binding stumbles over, AttributeError among them.
        except Exception as error:
            problem = f"{backend} gives no OpenGL context: {str(error).strip() or type(error).__name__}"
            mend = f"{VARIABLE} chooses another: {', '.join(_ALLOWED)}. {_INSTALL}"
            raise NoRendering(" ".join(problem.split()), mend=mend) from error

    def close(self) -> None:
        """Give it back; at the program's end its library may be gone already."""
        self._context.free()


def _backend(asked: str) -> str:
    """Return which of mujoco's modules makes the context."""
    if asked in _OFF:
        raise NoRendering(f"{VARIABLE}={asked} says so", mend=f"Unset {VARIABLE} to have pictures.")
    if asked:
        if asked not in _ALLOWED:
            raise NoRendering(f"{VARIABLE}={asked} is none of {', '.join(_ALLOWED)}", mend=f"Unset {VARIABLE}.")
        return asked
    for backend, names in _LIBRARIES.items():
        if any(_loads(name) for name in names):
            return backend
    raise NoRendering("neither libEGL nor libOSMesa is installed", mend=_INSTALL)


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


def _renderer() -> str:
    from OpenGL import GL

    name, version = (GL.glGetString(which) for which in (GL.GL_RENDERER, GL.GL_VERSION))
    return f"{name.decode()}, OpenGL {version.decode()}"
