"""Where nothing can draw, the reason is said in words."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from tests.drawing import require_rendering
from waypointctl.sim import offscreen
from waypointctl.sim.offscreen import NoRendering, OffscreenContext


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        ("disable", "MUJOCO_GL=disable turns rendering off\n  Unset MUJOCO_GL"),
        ("OFF", "MUJOCO_GL=off turns rendering off"),
        ("vulkan", "MUJOCO_GL=vulkan is not one of egl, osmesa, glfw, disable"),
    ],
)
def test_what_the_environment_says_is_done(monkeypatch: pytest.MonkeyPatch, value: str, problem: str) -> None:
    monkeypatch.setenv("MUJOCO_GL", value)
    with pytest.raises(NoRendering) as caught:
        OffscreenContext(64, 64)
    assert str(caught.value).startswith(problem)


def test_without_a_library_it_is_said_which_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    monkeypatch.setattr(offscreen, "_LIBRARIES", {"egl": ("libnone.so.1",), "osmesa": ("libnothing.so",)})
    with pytest.raises(NoRendering, match=r"neither libEGL nor libOSMesa is installed\n  .*apt-get install libegl1"):
        OffscreenContext(64, 64)


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (ImportError("Cannot initialize\n a EGL device display."), "Cannot initialize a EGL device display."),
        (AttributeError("'NoneType' object has no attribute 'glGetError'"), "its library is missing or broken"),
        (RuntimeError(""), "its library is missing or broken"),
    ],
)
def test_a_driver_that_fails_is_no_traceback(monkeypatch: pytest.MonkeyPatch, error: Exception, words: str) -> None:
    def opened(*_: object) -> None:
        raise error

    monkeypatch.setenv("MUJOCO_GL", "egl")
    monkeypatch.setattr(offscreen, "_opened", opened)
    with pytest.raises(NoRendering) as caught:
        OffscreenContext(64, 64)
    assert caught.value.problem == f"egl gives no OpenGL context: {words}"
    assert "MUJOCO_GL" in str(caught.value.hint)


@pytest.mark.parametrize("value", ["osmesa", "vulkan"])
def test_mujoco_is_imported_whatever_the_environment_names(value: str) -> None:
    """By itself it fails on import with an OpenGL that there is not."""
    code = "import waypointctl.sim.stepping, os; print(os.environ['MUJOCO_GL'])"
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | {"MUJOCO_GL": value}, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout.strip()) == (0, value), done.stderr


def test_a_context_can_be_made_again_after_it_was_closed() -> None:
    require_rendering()
    names = []
    for _ in range(3):
        context = OffscreenContext(64, 64)
        names.append(context.renderer)
        context.close()
    assert len(set(names)) == 1
    assert "OpenGL" in names[0]


def test_a_context_that_nobody_closed_ends_with_the_program_in_silence() -> None:
    require_rendering()
    code = "from waypointctl.sim.offscreen import OffscreenContext; context = OffscreenContext(64, 64)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert (done.stdout, done.stderr) == ("", "")
