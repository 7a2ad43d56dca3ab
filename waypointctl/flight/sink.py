"""Where the messages of a flight go."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from waypointctl.log.messages import Event, EventKind, Message, Picture, State

Sink: TypeAlias = Callable[[Message], None]


def tee(*sinks: Sink) -> Sink:
    """Return a sink that hands each message to all of `sinks`, in order."""
    if len(sinks) == 1:
        return sinks[0]

    def hand_on(message: Message) -> None:
        for sink in sinks:
            sink(message)

    return hand_on


Camera: TypeAlias = Callable[[Event, State], Picture | None]


def with_pictures(sink: Sink, camera: Camera) -> Sink:
    """Return a sink that hands each message on, and after the state of an observation the picture of it.

    A robot that rests shows its next state only when it wakes: it has not moved meanwhile.

    Args:
        sink: takes the messages and the pictures.
        camera: makes the picture of an observation at a state; None where it cannot.
    """
    observations: list[Event] = []

    def take(message: Message) -> None:
        sink(message)
        if isinstance(message, Event) and message.kind is EventKind.OBSERVATION_TAKEN:
            observations.append(message)
        elif observations and isinstance(message, State):
            for event in observations:
                picture = camera(event, message)
                if picture is not None:
                    sink(picture)
            observations.clear()

    return take
