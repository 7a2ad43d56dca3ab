"""Writing a file so that it appears whole."""

from __future__ import annotations

import os
from pathlib import Path

from waypointctl.errors import OutputError


def write_whole(path: Path, content: bytes) -> None:
    """Write a file under another name beside it and move it into place.

    Raises:
        OutputError: it cannot be written; what was there before still is.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        part.write_bytes(content)
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise OutputError(f"cannot be written: {error.strerror}", where=str(path)) from error
