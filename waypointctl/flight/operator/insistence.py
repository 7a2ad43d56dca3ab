"""How hard the ground tries to be heard."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Insistence:
    """How hard the ground tries to be heard.

    Attributes:
        acknowledged: whether it waits for acknowledgements at all.
        retries: how often a command is sent again at most, whatever for.
        answer_by: told when a command's last bit leaves [ns], says by when it has to be acknowledged [ns]; None for
            never, where no contact is left.
        patience_ns: how long after a frame that tells a command's end its acknowledgement may still come.
    """

    acknowledged: bool
    retries: int
    answer_by: Callable[[int], int | None]
    patience_ns: int
