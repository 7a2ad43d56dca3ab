"""Where a list of MAVLink mission items leads a robot on the ground.

Altitudes are not used, and where latitude and longitude are both 0 or not a number the item is about where the vehicle
is. A jump is repeated as often as its count, from its own place, as ArduPilot and PX4 do it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from waypointctl.importers.importer import MOST_STOPS, Report, Stop
from waypointctl.importers.mavlink import (
    DELAY,
    ENDS,
    FOLLOWED,
    GLOBAL_FRAMES,
    HERE,
    HOLDS,
    JUMP,
    JUMPS,
    LANDINGS,
    LOITER_TIME,
    NOT_DONE,
    PICTURE,
    RETURN,
    SHOOT,
    TAG,
    TAKEOFFS,
    WAYPOINT,
    other_commands,
)
from waypointctl.mission.fields import DAY_S

PARAMETERS: Final = 7
_HOLD: Final = 0
_TIME_OF_DAY: Final = slice(1, 4)  # of a delay: hour, minute, second, -1 for none
_RADIUS: Final = 1
_LOITER_RADIUS: Final = 2  # of a waypoint by which to pass it
_YAW: Final = 3
LATITUDE: Final = 4
LONGITUDE: Final = 5
_TIMES: Final = 1  # of a jump: how often
_IMAGES: Final = 2  # of a picture: how many
_SHOT: Final = 4  # of camera control: 1 to take one
_MOST_RADIUS_M: Final = 100.0
_MOST_STEPS: Final = 100_000


@dataclass(frozen=True, slots=True)
class Item:
    """A mission item."""

    at: str  # its place in the file, for messages
    number: int  # that jumps name it by
    command: int  # MAV_CMD
    frame: int | None  # MAV_FRAME; None where the file does not give it
    params: tuple[float | None, ...]  # the seven, None for what is not a number
    goes_on: bool = True  # whether the next follows by itself

    @property
    def is_here(self) -> bool:
        """Whether the item has no place of its own."""
        return not any(self.params[LATITUDE : LONGITUDE + 1])


def follow(items: Sequence[Item], report: Report) -> tuple[Stop, ...]:
    """Return the stops that items lead to; what cannot be followed and what is left out goes into the report."""
    way = _Way(report)
    for item in items:
        way.check(item)
    return way.stops_of(items) if report.is_clean else ()


@dataclass(slots=True)
class _Way:
    report: Report
    stops: list[Stop] = field(default_factory=list)

    def check(self, item: Item) -> None:
        """Report an item that cannot be followed; count one that is left out."""
        number = item.command
        if number in FOLLOWED:
            return
        other = other_commands().get(number)
        if other is None:
            problem = f"{number} is not a mission command of MAVLink that is known"
            self.report.add_problem(f"{item.at}.command", problem, "unknown command")
        elif other.is_left_out:
            self._leave_out(f"{other.name} (command {number}): {other.reason}")
        else:
            self.report.add_problem(f"{item.at}.command", f"{number} is {other.name}: {other.reason}")

    def stops_of(self, items: Sequence[Item]) -> tuple[Stop, ...]:
        """Return the stops of items that can be followed, their jumps unrolled."""
        backwards = list(enumerate(items))[::-1]  # of two with one number the first counts
        places = {float(item.number): place for place, item in backwards}
        tags = {item.params[0]: place for place, item in backwards if item.command == TAG}
        last = next((place for place, item in backwards if item.command in FOLLOWED and item.command != TAG), 0)
        jumped: Counter[int] = Counter()
        reached: set[int] = set()
        place = steps = 0
        while place < len(items) and len(self.stops) <= MOST_STOPS and steps < _MOST_STEPS:
            item, steps = items[place], steps + 1
            reached.add(place)
            if item.command in JUMPS:
                target = self._target(item, places.get if item.command == JUMP else tags.get)
                if target is None:
                    return ()
                if jumped[place] < (item.params[_TIMES] or 0):
                    jumped[place] += 1
                    place = target
                    continue
            elif item.command in FOLLOWED and item.command != TAG:
                self._take(item, is_last=place == last)
            if item.command == RETURN:  # the mission ends there
                self._leave_out_after(place, items, reached)
                place = len(items)
            place += 1
        if place < len(items) or len(self.stops) > MOST_STOPS:
            problem = f"leads to more than the {MOST_STOPS:,} waypoints that a mission can have"
            self.report.add_problem(items[0].at.rpartition("[")[0], f"{problem}: cut it into several")
        return tuple(self.stops)

    def _leave_out_after(self, end: int, items: Sequence[Item], reached: Container[int]) -> None:
        for place, item in enumerate(items):
            if place > end and place not in reached and item.command in FOLLOWED:
                self._leave_out("item after the return (command 20), which ends the mission")

    def _target(self, item: Item, place_of: Callable[[float], int | None]) -> int | None:
        """Return where a jump leads, None where it cannot be done, which is reported."""
        number, times = item.params[0], item.params[_TIMES]
        what = f"is a {FOLLOWED[item.command]} (command {item.command})"
        if times is not None and times < 0:
            self.report.add_problem(item.at, f"{what} without end: the mission's 'repeat' repeats the whole of it")
            return None
        target = None if number is None else place_of(number)
        if target is None:
            self.report.add_problem(item.at, f"{what} to {_shown(number)}, and no item has that number")
        return target

    def _take(self, item: Item, *, is_last: bool) -> None:
        command = item.command
        if not item.goes_on and not is_last:
            self._leave_out("wait for a person (autoContinue is false): the robot continues")
        if command in ENDS and not is_last and not (command == RETURN and self.stops):
            problem = f"is a {FOLLOWED[command]} (command {command}), and items follow it, which are never reached"
            self.report.add_problem(item.at, f"{problem}: end the plan there, or remove it")
        if command in NOT_DONE:
            self._leave_out(f"{FOLLOWED[command]} (command {command}): {NOT_DONE[command]}")
        if command == RETURN:
            self.stops.append(Stop(None, "home", item.at))
        elif command == DELAY:
            self._wait(item)
        elif command in (PICTURE, SHOOT):
            self._observe(item)
        elif item.is_here:
            self._stay(item)
        else:
            self._go_to(item)

    def _go_to(self, item: Item) -> None:
        """Take an item with a place."""
        if item.frame not in GLOBAL_FRAMES:
            allowed = ", ".join(map(str, GLOBAL_FRAMES))
            found = "is missing" if item.frame is None else f"{item.frame} is not one with latitude and longitude"
            self.report.add_problem(f"{item.at}.frame", f"{found}; {allowed} are")
            return
        command = item.command
        place = self.report.place(f"{item.at}.params", item.params[LATITUDE], item.params[LONGITUDE])
        hold_s = self._hold_s(item)
        radius_m = item.params[_RADIUS] or 0.0 if command == WAYPOINT else 0.0
        if not 0 <= radius_m <= _MOST_RADIUS_M:
            problem = f"an acceptance radius of {radius_m:g} m is not within 0 and {_MOST_RADIUS_M:g} m"
            self.report.add_problem(f"{item.at}.params[{_RADIUS}]", problem, "radius")
        self._note_what_is_not_done(item)
        if place is not None and hold_s is not None:
            name = "land" if command in LANDINGS else "takeoff" if command in TAKEOFFS else ""
            stop = Stop(place, name, item.at, hold_s, radius_m or None, needs_way=command in TAKEOFFS)
            self.stops.append(stop)

    def _stay(self, item: Item) -> None:
        """Take an item that is about where the robot is."""
        if item.command not in HERE:
            problem = "has no place: latitude and longitude (the fifth and the sixth) are 0 or null"
            self.report.add_problem(f"{item.at}.params", problem)
        elif hold_s := self._hold_s(item):
            self._stop_here(hold_s=hold_s)

    def _wait(self, item: Item) -> None:
        delay_s = item.params[_HOLD] or 0.0
        has_time_of_day = any((number or 0.0) > 0 for number in item.params[_TIME_OF_DAY])
        if delay_s < 0 or (not delay_s and has_time_of_day):
            problem = "waits for a time of day, which a mission does not know: give seconds (the first parameter)"
            self.report.add_problem(item.at, problem)
        elif hold_s := self._hold_s(item):
            self._stop_here(hold_s=hold_s)

    def _observe(self, item: Item) -> None:
        """Take an order for one picture: where the robot is, it is observed."""
        one = item.params[_SHOT if item.command == SHOOT else _IMAGES] == 1
        if one:
            self._stop_here(observe=True)
        else:
            what = f"{FOLLOWED[item.command]} (command {item.command})"
            self._leave_out(f"{what}: only one picture at a time is taken, at a waypoint")

    def _stop_here(self, hold_s: float = 0.0, observe: bool = False) -> None:
        """Add a stop at the current place, before the first waypoint at the start."""
        if not self.stops:
            self.stops.append(Stop(None, "start"))
        last = self.stops[-1]
        self.stops[-1] = replace(last, hold_s=last.hold_s + hold_s, observe=last.observe or observe)

    def _hold_s(self, item: Item) -> float | None:
        """Return how long an item holds [s], None where that is out of bounds, which is reported."""
        hold_s = item.params[_HOLD] or 0.0 if item.command in HOLDS else 0.0
        if 0 <= hold_s <= DAY_S:
            return hold_s
        self.report.add_problem(f"{item.at}.params[{_HOLD}]", f"{hold_s:g} s is not within 0 and {DAY_S:g} s", "hold")
        return None

    def _note_what_is_not_done(self, item: Item) -> None:
        if item.command == WAYPOINT and item.params[_LOITER_RADIUS]:
            self._leave_out("passing radius of a waypoint: the robot goes to the waypoint")
        if item.command == LOITER_TIME and item.params[_LOITER_RADIUS]:
            self._leave_out("loiter radius: the robot holds at the centre")
        if item.command in (WAYPOINT, *LANDINGS, *TAKEOFFS) and item.params[_YAW]:
            self._leave_out("heading at a waypoint: the policy sets the heading")

    def _leave_out(self, what: str) -> None:
        self.report.left_out[what] += 1


def _shown(number: float | None) -> str:
    return "nothing" if number is None else f"{number:g}"
