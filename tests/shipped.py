"""Flights of the shipped missions, each flown once in a test process."""

from __future__ import annotations

import atexit
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

from tests.golden import recording
from waypointctl.log.messages import Message
from waypointctl.log.reader import open_log


@cache
def shipped_flight(name: str) -> tuple[dict[str, Any], Path]:
    """Return the hashes and the result of a mission's flight, as `recording.flight` has them, and its log."""
    log = _folder() / f"{name}.mcap"
    return recording.flight(name, log=log), log


@cache
def shipped_messages(name: str) -> tuple[Message, ...]:
    """Return the messages of a mission's flight."""
    return tuple(open_log(shipped_flight(name)[1]).messages())


@cache
def _folder() -> Path:
    folder = tempfile.TemporaryDirectory()
    atexit.register(folder.cleanup)
    return Path(folder.name)
