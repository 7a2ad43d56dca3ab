"""What a person types at the console of a flight under way, as orders."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, get_args

from waypointctl.log.messages import CommandKind
from waypointctl.mission.fields import Timeout, Tolerance
from waypointctl.mission.mission import Mission
from waypointctl.mission.quantity import Quantity
from waypointctl.ops.executive.arguments import is_timeout, is_tolerance
from waypointctl.ops.executive.rules import rules_of
from waypointctl.ops.ground.order import Order
from waypointctl.ops.ground.schedule import place
from waypointctl.units import ns

_FURTHEST_M: Final = 10_000.0
_WORDS: Final = {
    "hold": CommandKind.HOLD,
    "resume": CommandKind.RESUME,
    "skip": CommandKind.SKIP,
    "abort": CommandKind.ABORT,
    "home": CommandKind.RETURN_HOME,
}
USAGE: Final = (
    "goto X Y [m] | hold | resume | skip | cancel ID | release N | tolerance M | timeout S | home | abort | "
    "status | time | help | quit"
)


def order_from(line: str, mission: Mission) -> Order:
    """Return the order that a line asks for.

    Raises:
        ValueError: it asks for none; the message says what can be asked for.
    """
    word, *arguments = line.split()
    if word in _WORDS:
        _expect(word, arguments, "")
        return Order(_WORDS[word])
    if word == "goto":
        x_m, y_m = _numbers(word, arguments, "X Y", 2)
        if max(abs(x_m), abs(y_m)) > _FURTHEST_M:
            raise ValueError(f"goto: {x_m:g} {y_m:g} is further than {_FURTHEST_M:g} m")
        return Order(CommandKind.GO_TO, (place((x_m, y_m), mission),))
    if word in _VALUED:
        (value,) = _numbers(word, arguments, "a number", 1)
        return _VALUED[word](value)
    raise ValueError(f"{word!r} is no command here; there are: {USAGE}")


def impossible(order: Order, mission: Mission) -> str:
    """Return why an order can never be obeyed, whatever the robot is doing, and what is allowed; empty if it can.

    What depends on the robot is the robot's to say. A line from a log is not judged by this: it was sent.
    """
    match order.kind:
        case CommandKind.SET_TOLERANCE if not is_tolerance(order.value):
            return f"tolerance: {order.value:g} m is not {_range(Tolerance)}; type tolerance 0.5, for instance"
        case CommandKind.SET_TIMEOUT if not is_timeout(order.value) or ns(order.value) < 1:
            return f"timeout: {order.value:g} s is not {_range(Timeout)}; type timeout 30, for instance"
        case CommandKind.RELEASE if order.released < -1:
            return f"release: {order.released} is no number of waypoints; type 0 or more, or -1 for all"
        case CommandKind.CANCEL if order.target_id < 1:
            return f"cancel: {order.target_id} is no command; their ids count from 1, and `status` lists them"
    fence = rules_of(mission).fence
    breaches = ((place, fence.breach(place.x_m, place.y_m)) for place in order.waypoints)
    outside = next((f"({place.x_m:g}, {place.y_m:g}) {breach}" for place, breach in breaches if breach), "")
    return f"goto: {outside}; the robot takes no goal there, the mission's geofence says so" if outside else ""


def _range(field: object) -> str:
    """Return the bounds of a mission file's number, in words."""
    (bounds,) = (part for part in get_args(field) if isinstance(part, Quantity))
    return f"more than {bounds.gt:g} {bounds.unit} and at most {bounds.le:g} {bounds.unit}"


def _whole(word: str, value: float) -> int:
    if value != int(value):
        raise ValueError(f"{word}: {value:g} is not a whole number")
    return int(value)


_VALUED: Final[dict[str, Callable[[float], Order]]] = {
    "cancel": lambda value: Order(CommandKind.CANCEL, target_id=_whole("cancel", value)),
    "release": lambda value: Order(CommandKind.RELEASE, released=_whole("release", value)),
    "tolerance": lambda value: Order(CommandKind.SET_TOLERANCE, value=value),
    "timeout": lambda value: Order(CommandKind.SET_TIMEOUT, value=value),
}


def _numbers(word: str, arguments: list[str], wanted: str, count: int) -> list[float]:
    try:
        numbers = [float(argument) for argument in arguments]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(abs(number) < float("inf") for number in numbers):
        raise ValueError(f"{word} takes {wanted}, not {' '.join(arguments) or 'nothing'!r}")
    return numbers


def _expect(word: str, arguments: list[str], wanted: str) -> None:
    if arguments:
        raise ValueError(f"{word} takes nothing after it, not {' '.join(arguments)!r}")
