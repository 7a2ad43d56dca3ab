"""Whether pictures can be drawn where the tests run."""

from __future__ import annotations

from functools import cache

import pytest

from waypointctl.sim.offscreen import NoRendering, OffscreenContext


def require_rendering() -> None:
    """Skip a test that needs OpenGL where there is none."""
    if problem := _problem():
        pytest.skip(f"nothing can draw here: {problem}")


@cache
def _problem() -> str:
    try:
        OffscreenContext(64, 64).close()
    except NoRendering as error:
        return str(error)
    return ""
