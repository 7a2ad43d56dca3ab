"""Who writes a log: a lock on its file that ends with the process, however that ends."""

from __future__ import annotations

import fcntl
from typing import IO


def lock(stream: IO[bytes]) -> bool:
    """Lock an open file until it is closed; return False if another process has locked it.

    Where the file system knows no locks, everybody gets one.
    """
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return True
