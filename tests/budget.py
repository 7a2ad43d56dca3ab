"""How many random examples a test tries: few for `make test`, all with THOROUGH=1, as `make test-all` sets it."""

from __future__ import annotations

import os


def examples(count: int) -> int:
    """Return how many of `count` examples are tried."""
    return count if os.environ.get("THOROUGH") else max(count // 8, 5)
