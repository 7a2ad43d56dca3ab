"""QGroundControl's .plan: its waypoints and its geofence.

The format: https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html; what the commands' seven
parameters mean: https://mavlink.io/en/messages/common.html. A walking robot has no use for altitudes.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Final

from waypointctl.mission.json_source import Part, read_json
from waypointctl.mission.local_frame import Place
from waypointctl.mission.survey import Stop, Survey, Zone, mission_name, place_of

WAYPOINT: Final = 16
LOITER_TIME: Final = 19
RETURN: Final = 20
LAND: Final = 21
TAKEOFF: Final = 22

_NAMES: Final = {WAYPOINT: "waypoint", LOITER_TIME: "loiter", RETURN: "return", LAND: "land", TAKEOFF: "takeoff"}
_GLOBAL_FRAMES: Final = (0, 3, 5, 6, 10, 11)  # MAV_FRAMEs with latitude and longitude
_PARAMETERS: Final = 7
_HOLD: Final = 0
_RADIUS: Final = 1
_LATITUDE: Final = 4
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
    stops = tuple(_stops(mission, home))
    zones = tuple(_zones(root))
    if not stops and not report.problems:
        mission.complain("has no waypoint to walk to: at least one item of command 16 is needed")
    report.refuse()
    assert home is not None
    if root.has("rallyPoints") and any(points := list(_rally(root))):
        report.notes.append(f"rallyPoints: {len(points)}; the robot has one home, onboard.home")
    return Survey(mission_name(path.stem), origin or home, home, stops, zones, tuple(report.notes))


def _home(mission: Part) -> Place | None:
    position = mission.at("plannedHomePosition")
    return None if position is None else _place(position)


def _place(part: Part) -> Place | None:
    """Return the place that a list [latitude, longitude, ...] says."""
    elements = list(part.elements())
    if len(elements) < 2:
        if isinstance(part.value, list):
            part.complain(f"has {len(elements)} numbers; latitude and longitude are needed")
        return None
    return place_of(elements[0], elements[1])


def _stops(mission: Part, home: Place | None) -> Iterator[Stop]:
    items = list(mission.each("items"))
    for place, item in enumerate(items):
        command = _command(item)
        if command is None:
            continue
        if command in (RETURN, LAND) and place + 1 < len(items):
            item.complain(f"is a {_NAMES[command]} (command {command}), and more follows: it has to be the last")
        if item.value.get("autoContinue") is False:
            item.note("that it waits here for a person (autoContinue)")
        if command == TAKEOFF:
            item.note("a takeoff; the robot walks from where it stands")
        elif command == RETURN:
            if home is not None:
                yield Stop(home, "home")
        elif (stop := _stop(item, command)) is not None:
            yield stop


def _command(item: Part) -> int | None:
    """Return the command of an item, None where it is none that can be followed, which is reported."""
    kind = item.at("type")
    if kind is None:
        return None
    if kind.value == "ComplexItem":
        kind.complain("'ComplexItem' (a survey, a scan) is not read: have QGroundControl make simple items of it")
        return None
    command = item.at("command") if kind.one_of("SimpleItem") else None
    if command is None:
        return None
    if type(command.value) is not int or command.value not in _NAMES:
        allowed = ", ".join(f"{number} ({name})" for number, name in _NAMES.items())
        command.complain(f"{command.value!r} is nothing that a walking robot does; allowed are {allowed}")
        return None
    return command.value


def _stop(item: Part, command: int) -> Stop | None:
    frame, params = item.at("frame"), item.at("params")
    if frame is None or params is None or not frame.one_of(*_GLOBAL_FRAMES):
        return None
    values = list(params.elements())
    if len(values) != _PARAMETERS:
        if isinstance(params.value, list):
            params.complain(f"has {len(values)} entries; a simple item has {_PARAMETERS}")
        return None
    latitude, longitude = values[_LATITUDE : _LATITUDE + 2]
    if not latitude.value and not longitude.value:
        params.complain("has no place: latitude and longitude (the fifth and the sixth) are 0 or null")
        return None
    place = place_of(latitude, longitude)
    hold_s = _optional(values[_HOLD], _DAY_S) if command in (WAYPOINT, LOITER_TIME) else 0.0
    radius_m = _optional(values[_RADIUS], 100.0) if command == WAYPOINT else 0.0
    if place is None or hold_s is None or radius_m is None:
        return None
    return Stop(place, "land" if command == LAND else "", hold_s, radius_m or None)


def _optional(part: Part, most: float) -> float | None:
    return 0.0 if part.value is None else part.number(0, most)


def _zones(root: Part) -> Iterator[Zone]:
    fence = root.at("geoFence") if root.has("geoFence") else None
    if fence is None:
        return
    version = fence.at("version")
    if version is None or not version.one_of(2):
        return
    for circle in fence.each("circles"):
        inclusion, inner = circle.at("inclusion"), circle.at("circle")
        if inclusion is None or inner is None or not inclusion.one_of(True, False):
            continue
        center, radius = inner.at("center"), inner.at("radius")
        place = None if center is None else _place(center)
        radius_m = None if radius is None else radius.number(0.001, 20_000)
        if place is not None and radius_m is not None:
            yield Zone(inclusion.value, (place,), radius_m)
    for polygon in fence.each("polygons"):
        inclusion, corners = polygon.at("inclusion"), polygon.at("polygon")
        if inclusion is None or corners is None or not inclusion.one_of(True, False):
            continue
        places = [place for place in (_place(corner) for corner in corners.elements()) if place is not None]
        if len(places) >= 3:
            yield Zone(inclusion.value, tuple(places))
        elif isinstance(corners.value, list):
            corners.complain(f"has {len(places)} corners; at least 3 are needed")


def _rally(root: Part) -> Iterator[Part]:
    rally = root.at("rallyPoints")
    if rally is not None:
        yield from rally.each("points")
