"""Both directions of the link as a checkpoint has them: what is under way, and the random streams."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

from waypointctl.flight.link.direction import Direction
from waypointctl.log.messages import Ack, Command, Telemetry


def link_state(up: Direction[Any], down: Direction[Any]) -> dict[str, object]:
    """Return what later arrivals depend on, as plain data.

    Of telemetry only the frames' numbers, of the first and the last to arrive: over a slow link thousands may be under
    way.
    """
    arriving = [message for _, message in down.under_way]
    frames = [message.frame for message in arriving if isinstance(message, Telemetry)]
    acks = [_plain(message) for message in arriving if isinstance(message, Ack)]
    commands = [_command(message) for _, message in up.under_way if isinstance(message, Command)]
    return {
        "up": {"commands": commands, **up.state()},
        "down": {"acks": acks, "frames": frames[:1] + frames[1:][-1:], **down.state()},
    }


def _command(command: Command) -> dict[str, object]:
    return _plain(command) | {"waypoints": [_plain(waypoint) for waypoint in command.waypoints]}


def _plain(record: Any) -> dict[str, object]:
    """Return a record's fields by name; not copied, as `asdict` does: there may be thousands of records."""
    return {each.name: getattr(record, each.name) for each in fields(record)}
