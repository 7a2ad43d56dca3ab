"""OpenGL without a screen, and why there is none where there is none."""

from __future__ import annotations

import atexit
import ctypes
import importlib
import os
import warnings
from typing import Any, Final

from waypointctl.errors import InputError

VARIABLE: Final = "MUJOCO_GL"  # MuJoCo's own: which OpenGL is to be used
_OFF: Final = ("disable", "disabled", "off", "false", "0")
_LIBRARIES: Final = {
    "egl": ("libEGL.so.1", "libEGL.so"),
    "osmesa": ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"),
}
_ALLOWED: Final = ("egl", "osmesa", "glfw", "disable")
_INSTALL: Final = "Install one, such as with: apt-get install libegl1 libopengl0 libgl1-mesa-dri"


class NoRendering(InputError):
    """No renderer is available."""


class OffscreenContext:
    """An OpenGL context, current as soon as it is made.

    Attributes:
        renderer: what draws, such as "llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5 Mesa 22.3.6".
    """

    def __init__(self, width: int, height: int) -> None:
        """Make a context for pictures of at most this size [pixels].

        Raises:
            NoRendering: there is no OpenGL, or the environment turns it off.
        """
        backend = _backend(os.environ.get(VARIABLE, "").strip().lower())
        try:
            self._context = _opened(backend, width, height)
            # The module closes its library at the program's end: what was not closed before has to be given back first.
            atexit.register(self._context.free)
            self.renderer = _renderer()
        # A driver that is missing or broken shows as whatever its binding stumbles over.
        except Exception as error:
            hint = f"{VARIABLE} chooses another: {', '.join(_ALLOWED)}. {_INSTALL}"
            raise NoRendering(f"{backend} gives no OpenGL context: {_in_words(error)}", hint=hint) from error

    def make_current(self) -> None:
        """Draw here from now on: there may be others."""
        self._context.make_current()

    def close(self) -> None:
        """Give it back."""
        atexit.unregister(self._context.free)
        self._context.free()


def _opened(backend: str, width: int, height: int) -> Any:
    """Return a context of one of mujoco's modules, made current."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # GLFW warns of what makes it fail
        # Each of the modules picks PyOpenGL's platform for the whole process: import none but the one that is used.
        context = importlib.import_module(f"mujoco.{backend}").GLContext(width, height)
        context.make_current()
    return context


def _in_words(error: Exception) -> str:
    """Return what is wrong with a driver, as far as it is known."""
    if isinstance(error, AttributeError | TypeError) or not str(error).strip():
        return "its library is missing or broken"  # the binding met nothing where a function should be
    return " ".join(str(error).split())


def _backend(requested: str) -> str:
    """Return which of mujoco's modules makes the context."""
    if requested in _OFF:
        raise NoRendering(f"{VARIABLE}={requested} turns rendering off", hint=f"Unset {VARIABLE} to have pictures.")
    if requested:
        if requested not in _ALLOWED:
            raise NoRendering(f"{VARIABLE}={requested} is not one of {', '.join(_ALLOWED)}", hint=f"Unset {VARIABLE}.")
        return requested
    for backend, names in _LIBRARIES.items():
        if any(_loads(name) for name in names):
            return backend
    raise NoRendering("neither libEGL nor libOSMesa is installed", hint=_INSTALL)


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
