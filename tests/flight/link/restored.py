"""A direction of the link from the state of another one: a checkpoint has all that later messages depend on."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.impairments import BLOCK, Draws, GilbertElliott, RandomLoss

T = TypeVar("T")


def restore(direction: Direction[T], state: Mapping[str, Any], under_way: Iterable[tuple[int, T]]) -> None:
    """Let a new direction go on from a state, with what was under way, in order of arrival."""
    direction._free_ns, direction._last_arrival_ns = state["free_ns"], state["last_arrival_ns"]
    direction._waiting = deque((departs_ns, size_bytes) for departs_ns, size_bytes in state["waiting"])
    direction._waiting_bytes = sum(size_bytes for _, size_bytes in direction._waiting)
    direction._under_way = [(arrives_ns, number, message) for number, (arrives_ns, message) in enumerate(under_way)]
    direction._number = len(direction._under_way)
    for name, drawing in direction._draws().items():
        restore_draws(drawing, state["random"][name])


def restore_draws(drawing: object, state: Mapping[str, Any]) -> None:
    """Let what draws random numbers go on from a state of its like."""
    if isinstance(drawing, GilbertElliott):
        drawing.bad, drawing = state["bad"], drawing._pairs
    elif isinstance(drawing, RandomLoss):
        drawing = drawing._chances
    assert isinstance(drawing, Draws)
    drawing._rng.bit_generator.state = state["stream"]
    drawing._ahead = []
    if state["used"]:
        drawing._fill()
        del drawing._ahead[BLOCK - state["used"] :]
