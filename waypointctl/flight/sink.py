"""Where the messages of a flight go."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from waypointctl.log.messages import Message

Sink: TypeAlias = Callable[[Message], None]


def tee(*sinks: Sink) -> Sink:
    """Return a sink that hands each message to all of `sinks`, in order."""

    def hand_on(message: Message) -> None:
        for sink in sinks:
            sink(message)

    return hand_on
