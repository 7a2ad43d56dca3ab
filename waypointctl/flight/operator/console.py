"""What a person types at the console of a flight under way, as orders.

Quantities are written as in mission files, such as `goto 3 m 250 cm hold 5 s`; a number without a unit is in m or s.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Final, Protocol

from waypointctl.flight.executive.rules import fence_of
from waypointctl.flight.operator.requests import CommandRequest, place
from waypointctl.log.messages import CommandKind, PlannedWaypoint
from waypointctl.mission.fields import FURTHEST_M, Hold, Timeout, Tolerance, bounds_of
from waypointctl.mission.mission import Mission
from waypointctl.mission.operator import LARGEST_NUMBER
from waypointctl.units import DISTANCE_UNITS_M, DURATION_UNITS_S, NUMBER_PATTERN, ns, quantity, whole_ns

QUIT: Final = "quit"  # the line that ends it


class LineSource(Protocol):
    """What a flight asks for the lines that a person types while it is under way.

    Lines are taken at moments of the flight, once in each turn of its loop. While physics sleeps a turn may take
    minutes of simulation time, so the source limits how far time may jump.
    """

    is_open: bool  # whether a console is attached at mission start. Then the flight does not end before a line is QUIT

    def lines(self, now_ns: int) -> Iterable[str]:
        """Yield what has been typed by now and was not yet yielded: what `request_from` accepts, or QUIT.

        The next one is read when the one before has been executed. A source that keeps to wall time waits here.
        """

    def asleep(self, now_ns: int, until_ns: int) -> int:
        """Return when there is something to take, if that is before `until_ns`, or else that; both [ns].

        Between now and then nothing happens on the ground, on board or on the link.
        """


_WORDS: Final = {
    "hold": CommandKind.HOLD,
    "resume": CommandKind.RESUME,
    "skip": CommandKind.SKIP,
    "abort": CommandKind.ABORT,
    "home": CommandKind.RETURN_HOME,
}
USAGE: Final = (
    "goto X m Y m [hold T s] [tolerance D m] [timeout T s] | hold | resume | skip | cancel ID | release N | "
    "tolerance D m | timeout T s | home | abort | status | time | help | quit"
)
_QUANTITY: Final = re.compile(rf"\s*({NUMBER_PATTERN})\s*([A-Za-z/%]*)(?=[\s\d.+-]|$)")
_OPTION: Final = re.compile(r"\b(hold|tolerance|timeout)\b")


def request_from(line: str, mission: Mission) -> CommandRequest:
    """Return the command request of a line.

    Raises:
        ValueError: it is not a command; the message lists what is allowed.
    """
    word, rest = (*line.strip().split(None, 1), "", "")[:2]
    if word in _WORDS:
        if rest:
            also = "; `goto X m Y m hold 5 s` holds at a place" if word == "hold" else ""
            raise ValueError(f"{word} takes no argument; found {rest!r}{also}")
        return CommandRequest(_WORDS[word])
    if word == "goto":
        return CommandRequest(CommandKind.GO_TO, (_place(rest, mission),))
    if word in _VALUED:
        return _VALUED[word](rest)
    raise ValueError(f"unknown command {word!r}; commands are: {USAGE}")


def _place(text: str, mission: Mission) -> PlannedWaypoint:
    """Return the place of `goto`, with its options in place of the mission's defaults."""
    where, *options = _OPTION.split(text)
    x_m, y_m = _quantities("goto", where, "X m Y m", DISTANCE_UNITS_M, 2)
    if max(abs(x_m), abs(y_m)) > FURTHEST_M:
        raise ValueError(f"goto: {x_m:g} {y_m:g} is further than {FURTHEST_M:g} m")
    planned = place((x_m, y_m), mission)
    if twice := next((name for name in _OPTIONS if options[::2].count(name) > 1), ""):
        raise ValueError(f"goto: {twice} is given twice; give it once")
    for name, given in zip(options[::2], options[1::2], strict=True):
        planned = _OPTIONS[name](planned, given)
    return planned


def _tolerance_m(text: str) -> float:
    return _quantities("tolerance", text, "a length such as 0.5 m", DISTANCE_UNITS_M, 1)[0]


def _time_s(word: str, example: str, text: str) -> float:
    return _quantities(word, text, f"a time such as {example}", DURATION_UNITS_S, 1)[0]


def _within(name: str, value: float, field: object) -> float:
    """Return the value of an option of `goto`, within the bounds of a mission file's field."""
    if not bounds_of(field).fits(value):
        raise ValueError(f"goto: {name} {value:g} is not {_range(field)}")
    return value


_OPTIONS: Final[Mapping[str, Callable[[PlannedWaypoint, str], PlannedWaypoint]]] = {
    "tolerance": lambda it, text: replace(it, tolerance_m=_within("tolerance", _tolerance_m(text), Tolerance)),
    "timeout": lambda it, text: replace(
        it, timeout_ns=whole_ns(_within("timeout", _time_s("timeout", "30 s", text), Timeout))
    ),
    "hold": lambda it, text: replace(it, hold_ns=ns(_within("hold", _time_s("hold", "5 s", text), Hold))),
}


def _quantities(word: str, text: str, wanted: str, units: Mapping[str, float], count: int) -> Sequence[float]:
    """Return the numbers of a text, each with its unit or in the base unit."""
    values: list[float] = []
    at = 0
    base = next(unit for unit, factor in units.items() if factor == 1.0)
    while found := _QUANTITY.match(text, at):
        number, unit = found.groups()
        values.append(quantity(f"{number} {unit or base}", units))
        at = found.end()
    if text[at:].strip() or len(values) != count or not all(abs(value) < float("inf") for value in values):
        raise ValueError(f"{word} takes {wanted}, not {text.strip() or 'nothing'!r}")
    return values


def impossible(request: CommandRequest, mission: Mission) -> str:
    """Return why a request can never be executed, whatever the robot is doing, and what is allowed; empty if it can.

    What depends on the robot's state is checked on board. A line from a log is not checked: it was sent.
    """
    match request.kind:
        case CommandKind.SET_TOLERANCE if not bounds_of(Tolerance).fits(request.value):
            return f"tolerance: {request.value:g} m is not {_range(Tolerance)}; type tolerance 0.5 m, for instance"
        case CommandKind.SET_TIMEOUT if not bounds_of(Timeout).fits(request.value):
            return f"timeout: {request.value:g} s is not {_range(Timeout)}; type timeout 30 s, for instance"
        case CommandKind.RELEASE if request.released < -1:
            return f"release: {request.released} is not a number of waypoints; type 0 or more, or -1 for all"
        case CommandKind.CANCEL if request.target_id < 1:
            return f"cancel: {request.target_id} is not a command id; ids count from 1, and `status` lists them"
    fence = fence_of(mission)
    breaches = ((place, fence.breach(place.x_m, place.y_m)) for place in request.waypoints)
    outside = next((f"({place.x_m:g}, {place.y_m:g}) {breach}" for place, breach in breaches if breach), "")
    return f"goto: {outside}; the mission's geofence allows no goal there" if outside else ""


def _range(field: object) -> str:
    """Return the bounds of a mission file's number, in words."""
    bounds = bounds_of(field)
    least = f"more than {bounds.gt:g}" if bounds.ge is None else f"at least {bounds.ge:g}"
    return f"{least} {bounds.unit} and at most {bounds.le:g} {bounds.unit}"


def _whole(word: str, text: str) -> int:
    """Return a whole number that a command can carry."""
    if not re.fullmatch(NUMBER_PATTERN, text):
        raise ValueError(f"{word} takes a whole number, not {text or 'nothing'!r}")
    value = float(text)
    if not abs(value) <= LARGEST_NUMBER:
        raise ValueError(f"{word}: {text[:40]} is too large; command numbers go up to {LARGEST_NUMBER:,}")
    if value != int(value):
        raise ValueError(f"{word}: {value:g} is not a whole number")
    return int(value)


_VALUED: Final[Mapping[str, Callable[[str], CommandRequest]]] = {
    "cancel": lambda text: CommandRequest(CommandKind.CANCEL, target_id=_whole("cancel", text)),
    "release": lambda text: CommandRequest(CommandKind.RELEASE, released=_whole("release", text)),
    "tolerance": lambda text: CommandRequest(CommandKind.SET_TOLERANCE, value=_tolerance_m(text)),
    "timeout": lambda text: CommandRequest(CommandKind.SET_TIMEOUT, value=_time_s("timeout", "30 s", text)),
}
