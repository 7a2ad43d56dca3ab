"""Flights to test with: missions that need no policy worth the name, and waypointctl as a process."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from tests.forked import ForkedProgram

Program = Callable[..., tuple[int, str, str]]

# Both waypoints are where the robot stands, so that it succeeds whatever its policy does.
EASY = """\
name: easy
seed: 4
policy: still
defaults: {tolerance: 3 m}
waypoints:
  - {name: here, position: [0 m, 0 m], hold: 1 s}
  - {name: "there [/bold]", position: [0.5 m, 0 m]}
link: {delay: 0.5 s}
"""
FAR = """\
name: far
policy: still
waypoints: [{name: away, position: [50 m, 50 m], timeout: 1 s}]
link: {delay: 0.1 s}
"""
LONG = """\
name: long
policy: still
defaults: {tolerance: 3 m}
waypoints: [{name: rest, position: [0 m, 0 m], hold: 1 h}]
"""


def start(
    folder: Path,
    *arguments: str,
    stdin: int | None = None,
    stdout: int | None = None,
    stderr: int | None = None,
    **environment: str,
) -> ForkedProgram:
    """Start waypointctl as a process of its own."""
    return ForkedProgram(arguments, folder, {**os.environ, **environment}, (stdin, stdout, stderr))
