"""QGroundControl's .plan: its waypoints and its geofence.

The format: https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html; what the commands' seven
parameters mean: https://mavlink.io/en/messages/common.html. A walking robot has no use for altitudes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

from waypointctl.mission.json_source import Part, read_json
from waypointctl.mission.local_frame import Place
from waypointctl.mission.mavlink import (
    DELAY,
    FOLLOWED,
    INSTEAD,
    LANDINGS,
    LAST,
    LEFT_OUT,
    LOITER_TIME,
    NOT_DONE,
    PICTURE,
    RETURN,
    SHOOT,
    TAKEOFFS,
    WAYPOINT,
)
from waypointctl.mission.plan_fence import place_in, rally_points, zones_of
from waypointctl.mission.survey import Stop, Survey, mission_name, place_of

_GLOBAL_FRAMES: Final = (0, 3, 5, 6, 10, 11)  # MAV_FRAMEs with latitude and longitude
_PARAMETERS: Final = 7
_HOLD: Final = 0
_RADIUS: Final = 1
_LATITUDE: Final = 4
_IMAGES: Final = 2  # of a picture: how many
_SHOT: Final = 4  # of camera control: 1 to take one
_DAY_S: Final = 86_400.0


def read_plan(path: Path, origin: Place | None = None) -> Survey:
    """Read a plan.

    Args:
        path: of the file.
        origin: of the local frame; the planned home position where it is left out.

    Raises:
        MissionError: there is no such file, or it is no plan that a walking robot can follow, with all that is wrong.
    """
    root = read_json(path)
    report = root.report
    kind, version, mission = root.at("fileType"), root.at("version"), root.at("mission")
    report.refuse()
    assert kind is not None
    assert version is not None
    assert mission is not None
    kind.one_of("Plan")
    version.one_of(1)
    report.refuse()
    home = _home(mission)
    way = _Way(home)
    way.follow(mission)
    stops = tuple(way.stops)
    zones = tuple(zones_of(root))
    if not stops and not report.problems:
        mission.complain("has no waypoint to walk to: at least one item of command 16 is needed")
    report.refuse()
    assert home is not None
    report.notes += [f"{count} x {what}" for what, count in way.left_out.items()]
    if root.has("rallyPoints") and any(points := list(rally_points(root))):
        report.notes.append(f"rallyPoints: {len(points)}; the robot has one home, onboard.home")
    return Survey(mission_name(path.stem), origin or home, home, stops, zones, tuple(report.notes))


def _home(mission: Part) -> Place | None:
    position = mission.at("plannedHomePosition")
    return None if position is None else place_in(position)


@dataclass(slots=True)
class _Way:
    """Gathers where a plan's items lead.

    Attributes:
        home: what a return leads to, None where it is not known.
        stops: so far.
        left_out: what is left out, in words, and how often.
    """

    home: Place | None
    stops: list[Stop] = field(default_factory=list)
    left_out: Counter[str] = field(default_factory=Counter)

    def follow(self, mission: Part) -> None:
        """Take all items of a mission."""
        items = [(item, command) for item in _items(mission) if (command := self._command(item)) is not None]
        for place, (item, command) in enumerate(items):
            if command in LAST and place + 1 < len(items):
                item.complain(f"is a {FOLLOWED[command]} (command {command}), and more follows: it has to be the last")
            if item.value.get("autoContinue") is False:
                self.left_out["wait for a person (autoContinue is false): the robot goes on"] += 1
            self._take(item, command)

    def _command(self, item: Part) -> int | None:
        """Return the command of an item, None where it is left out or none that can be followed, which is reported."""
        kind = item.at("type")
        command = item.at("command") if kind is not None and kind.one_of("SimpleItem") else None
        if command is None:
            return None
        number = command.value
        if type(number) is int and number in FOLLOWED:
            return number
        if type(number) is int and number in LEFT_OUT:
            name, why = LEFT_OUT[number]
            self.left_out[f"{name} (command {number}): {why}"] += 1
        elif type(number) is int and number in INSTEAD:
            command.complain(f"{number} is {INSTEAD[number]}")
        else:
            allowed = ", ".join(f"{number} ({name})" for number, name in FOLLOWED.items())
            command.complain(f"{number!r} is nothing that a walking robot does; allowed are {allowed}")
        return None

    def _take(self, item: Part, command: int) -> None:
        if command in NOT_DONE:
            self.left_out[f"{FOLLOWED[command]} (command {command}): {NOT_DONE[command]}"] += 1
        if command in TAKEOFFS:
            return
        if command == RETURN:
            self.stops += [] if self.home is None else [Stop(self.home, "home")]
        elif command == DELAY:
            self._wait(item)
        elif command in (PICTURE, SHOOT):
            self._observe(item, command)
        elif command not in LAST or not _is_here(item):  # what ends without a place ends where the robot stands
            stop = _stop(item, command)
            self.stops += [] if stop is None else [stop]

    def _wait(self, item: Part) -> None:
        """Take a delay: the robot holds for longer where it is."""
        values = _parameters(item)
        delay_s = None if values is None else _optional(values[_HOLD], _DAY_S)
        if not delay_s:
            return
        if self.stops:
            self.stops[-1] = replace(self.stops[-1], hold_s=self.stops[-1].hold_s + delay_s)
        else:
            self.left_out[f"delay (command {DELAY}) before the first waypoint: the robot sets out at once"] += 1

    def _observe(self, item: Part, command: int) -> None:
        """Take an order for one picture: the waypoint before it is observed."""
        values = _parameters(item)
        if values is None:
            return
        one = values[_SHOT].value == 1 if command == SHOOT else values[_IMAGES].value == 1
        if one and self.stops:
            self.stops[-1] = replace(self.stops[-1], observe=True)
        elif one:
            self.left_out[f"{FOLLOWED[command]} (command {command}) before the first waypoint"] += 1
        else:
            self.left_out[
                f"{FOLLOWED[command]} (command {command}): only one picture at a time is taken, at a waypoint"
            ] += 1


def _items(mission: Part) -> Iterator[Part]:
    """Yield a mission's simple items, those too that a survey or a corridor scan has been laid out as."""
    for item in mission.each("items"):
        if not (isinstance(item.value, dict) and item.value.get("type") == "ComplexItem"):
            yield item
            continue
        transects = item.at("TransectStyleComplexItem") if item.has("TransectStyleComplexItem") else None
        if transects is not None and transects.has("Items") and transects.value["Items"] != []:
            yield from transects.each("Items")
        else:
            what = item.value.get("complexItemType", "no type")
            item.complain(f"is a ComplexItem ({what}) without the simple items of a survey: draw its waypoints")


def _parameters(item: Part) -> list[Part] | None:
    params = item.at("params")
    values = [] if params is None else list(params.elements())
    if params is None or len(values) == _PARAMETERS:
        return values or None
    if isinstance(params.value, list):
        params.complain(
            f"has {len(values)} {'entry' if len(values) == 1 else 'entries'}; a simple item has {_PARAMETERS}"
        )
    return None


def _is_here(item: Part) -> bool:
    """Tell whether an item has no place: latitude and longitude are 0 or null."""
    params = item.value.get("params")
    return isinstance(params, list) and len(params) == _PARAMETERS and not any(params[_LATITUDE : _LATITUDE + 2])


def _stop(item: Part, command: int) -> Stop | None:
    frame = item.at("frame")
    values = _parameters(item)
    if frame is None or values is None or not frame.one_of(*_GLOBAL_FRAMES):
        return None
    latitude, longitude = values[_LATITUDE : _LATITUDE + 2]
    if _is_here(item):
        missing = "has no place: latitude and longitude (the fifth and the sixth) are 0 or null"
        replace(item, path=(*item.path, "params")).complain(missing)
        return None
    place = place_of(latitude, longitude)
    hold_s = _optional(values[_HOLD], _DAY_S) if command in (WAYPOINT, LOITER_TIME) else 0.0
    radius_m = _optional(values[_RADIUS], 100.0) if command == WAYPOINT else 0.0
    if place is None or hold_s is None or radius_m is None:
        return None
    return Stop(place, "land" if command in LANDINGS else "", hold_s, radius_m or None)


def _optional(part: Part, most: float) -> float | None:
    return 0.0 if part.value is None else part.number(0, most)
