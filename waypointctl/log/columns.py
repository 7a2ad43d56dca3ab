"""Messages of one kind as columns of numpy arrays, for analysis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from waypointctl.log.messages import Message, Reward

Column = NDArray[Any]


def columns(messages: Sequence[Message]) -> dict[str, Column]:
    """Return each field of messages of one kind as an array, the message along the first axis.

    Numbers and texts are (n,); arrays that have the same shape in every message are stacked, (n, k); the terms of
    rewards are columns of their own. Fields without a fixed size, such as the waypoints of a command, are left out.
    """
    if not messages:
        return {}
    found = {}
    for field in fields(messages[0]):
        column = _column([getattr(message, field.name) for message in messages])
        if column is not None:
            found[field.name] = column
    rewards = [dict(message.terms) for message in messages if isinstance(message, Reward)]
    for name in dict.fromkeys(name for terms in rewards for name in terms):
        found[name] = np.array([terms.get(name, np.nan) for terms in rewards])
    return found


def _column(values: list[Any]) -> Column | None:
    first = values[0]
    if isinstance(first, np.ndarray):
        return np.stack(values) if all(value.shape == first.shape for value in values) else None
    if isinstance(first, str):
        return np.array([str(value) for value in values])
    return np.array(values) if isinstance(first, int | float) else None
