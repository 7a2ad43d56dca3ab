"""QGroundControl's .plan: its waypoints, its geofence and its rally points.

The format: https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html. Surveys and corridor scans
are followed along the simple items that QGroundControl laid them out as, a landing pattern along its two places.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.display_text import counted, shown
from waypointctl.importers.importer import ImportedMission, Importer, Report, Zone, number_of, of_kind
from waypointctl.importers.json_source import Part, is_number, is_unset, place_in, read_json
from waypointctl.importers.local_frame import Place
from waypointctl.importers.mavlink import LAND, LOITER_TO_ALTITUDE, VTOL_LAND
from waypointctl.importers.mavlink_way import PARAMETERS, Item, follow
from waypointctl.mission.file_kind import FileKind

_RELATIVE: Final = 3  # MAV_FRAME of altitudes above the home
_PATTERNS: Final = {"fwLandingPattern": LAND, "vtolLandingPattern": VTOL_LAND}
_OLD_PARAMETERS: Final = 4  # beside a 'coordinate', in the first plans
_FENCE_VERSION: Final = 2
_SHAPE_VERSION: Final = 1
_AREAS: Final = ("circles", "polygons", "circle", "polygon")  # the last two are of version 1
_MOST_RADIUS_M: Final = 20_000.0
_MOST_AREAS: Final = 100  # as many as a mission's geofence holds
_MOST_CORNERS: Final = 1000
_MOST_CORNERS_IN_ALL: Final = 3_000


def _read(source: bytes, report: Report) -> ImportedMission:
    root = read_json(source, report)
    mission = _mission_of(root)
    home = _home(mission)
    stops = follow(list(_items(mission)), report)
    zones, return_to = _fence(root, report)
    if not stops and report.is_clean:
        mission.add_problem("has no waypoint to go to: at least one item of command 16 is needed")
    if rally := _rally_count(root):
        report.left_out[f"rally point{'s' if rally > 1 else ''}: the robot has one home, onboard.home"] += rally
    return ImportedMission(
        home,
        stops,
        start_at="mission.plannedHomePosition",
        is_home=True,
        zones=zones,
        return_to=return_to,
    )


def _mission_of(root: Part) -> Part:
    """Return the part with the waypoints of a plan whose versions are those that are read."""
    if (kind := root.at("fileType")) is not None:
        kind.one_of("Plan")
    root.report.refuse()
    mission = root.at("mission")
    root.report.refuse()
    assert mission is not None
    if (version := root.at("version")) is not None:
        version.one_of(1)
    if not isinstance(mission.value, dict):
        mission.at("items")
    elif (version := mission.get("version")) is not None:
        version.one_of(2)
    root.report.refuse()
    return mission


def _home(mission: Part) -> Place | None:
    position = mission.get("plannedHomePosition")
    return None if position is None or is_unset(position) else place_in(position)


def _items(mission: Part) -> Iterator[Item]:
    for part in mission.each("items"):
        if isinstance(part.value, dict) and part.value.get("type") == "ComplexItem":
            yield from _laid_out(part)
        elif (item := _item(part)) is not None:
            yield item


def _laid_out(part: Part) -> Iterator[Item]:
    """Yield the simple items of a complex one; one that has none is reported."""
    kind = part.value.get("complexItemType")
    transects = part.get("TransectStyleComplexItem")
    if isinstance(kind, str) and kind in _PATTERNS:
        yield from _landing(part, _PATTERNS[kind])
    elif transects is not None and transects.has("Items") and transects.value["Items"] != []:
        yield from (item for inner in transects.each("Items") if (item := _item(inner)) is not None)
    else:
        what = shown(kind) if isinstance(kind, str) else "of no type"
        part.add_problem(f"is a ComplexItem ({what}) without the simple items of a survey: draw its waypoints")


def _landing(part: Part, command: int) -> Iterator[Item]:
    """Yield the approach of a landing pattern, and the landing at its end."""
    approach = "landingApproachCoordinate" if part.has("landingApproachCoordinate") else "loiterCoordinate"
    for key, as_command in ((approach, LOITER_TO_ALTITUDE), ("landCoordinate", command)):
        coordinate = part.at(key)
        place = None if coordinate is None else place_in(coordinate)
        if coordinate is not None and place is not None:
            yield Item(coordinate.at_text, -1, as_command, _RELATIVE, (None, None, None, None, *place, None))


def _item(part: Part) -> Item | None:
    """Return a simple item, None where it is none, which is reported."""
    kind = part.at("type")
    if kind is None or not kind.one_of("SimpleItem"):
        return None
    command, params = part.at("command"), part.at("params")
    number, frame = (None if each is None else each.whole() for each in (command, part.get("frame")))
    values = None if params is None else _parameters(part, params)
    if command is not None and number is None:
        command.add_problem(f"{shown(command.value)} is not the number of a command")
    if number is None or values is None:
        return None
    jump_id = part.get("doJumpId")
    name = None if jump_id is None else jump_id.whole()
    at = int(part.path[-1]) + 1
    goes_on = part.value.get("autoContinue") is not False
    return Item(part.at_text, at if name is None else name, number, frame, values, goes_on)


def _parameters(item: Part, params: Part) -> tuple[float | None, ...] | None:
    values = params.value
    if not isinstance(values, list):
        params.add_problem(f"{shown(values)} is not a list", "not a list")
        return None
    coordinate = item.value.get("coordinate")
    if len(values) == _OLD_PARAMETERS and isinstance(coordinate, list) and len(coordinate) == PARAMETERS - len(values):
        values = [*values, *coordinate]
    if len(values) != PARAMETERS:
        entries = "entry" if len(values) == 1 else "entries"
        params.add_problem(f"has {len(values)} {entries}; a simple item has {PARAMETERS}", "number of parameters")
        return None
    for place, value in enumerate(values):
        if is_number(value) and (isinstance(value, str) or number_of(value) is None):
            item.report.add_problem(f"{params.at_text}[{place}]", f"{shown(value)} is not a number", "not a number")
            return None
    return tuple(number_of(value) for value in values)


def _rally_count(root: Part) -> int:
    rally = root.get("rallyPoints")
    points = rally.value.get("points") if rally is not None and isinstance(rally.value, dict) else None
    return len(points) if isinstance(points, list) else 0


def _fence(root: Part, report: Report) -> tuple[tuple[Zone, ...], Place | None]:
    """Return the areas of a plan's fence, and where a vehicle goes that breaches it; what is wrong is reported.

    All inclusions of a plan hold together: the vehicle has to be inside each of them.
    """
    fence = root.get("geoFence")
    if fence is None or fence.value == []:
        return (), None
    if not isinstance(fence.value, dict):
        fence.at("version")
        return (), None
    if not any(fence.value.get(key) for key in _AREAS):
        if fence.has("breachReturn"):
            report.left_out["geoFence.breachReturn: the fence holds nothing, and cannot be broken"] += 1
        return (), None
    if not _is_read(fence):
        return (), None
    zones = (*_circles(fence), *_polygons(fence))
    if (corners := sum(len(zone.corners) for zone in zones)) > _MOST_CORNERS_IN_ALL:
        fence.add_problem(f"has {corners:,} corners; at most {_MOST_CORNERS_IN_ALL:,} are read")
    breach_return = fence.get("breachReturn")
    return zones, None if breach_return is None or is_unset(breach_return) else place_in(breach_return)


def _is_read(fence: Part) -> bool:
    """Tell whether a fence that holds something is of the version that is read; any other is reported."""
    old = next((key for key in ("polygon", "circle") if fence.value.get(key)), None)
    version = fence.get("version")
    if version is not None and not version.one_of(_FENCE_VERSION):
        return False
    if old is not None:
        fence.add_problem(f"has a '{old}', as version 1 had; version 2 has 'polygons' and 'circles'")
    return old is None


def _circles(fence: Part) -> Iterator[Zone]:
    for circle in fence.each("circles", _MOST_AREAS):
        inclusion, inner = circle.at("inclusion"), circle.at("circle")
        if inclusion is None or inner is None or not inclusion.one_of(True, False) or not _is_known(circle):
            continue
        center, radius = inner.at("center"), inner.at("radius")
        place = None if center is None else place_in(center)
        radius_m = None if radius is None else radius.number(0.001, _MOST_RADIUS_M)
        if place is not None and radius_m is not None:
            yield Zone(inclusion.value, (place,), radius_m, circle.at_text)


def _polygons(fence: Part) -> Iterator[Zone]:
    for polygon in fence.each("polygons", _MOST_AREAS):
        inclusion, corners = polygon.at("inclusion"), polygon.at("polygon")
        if inclusion is None or corners is None or not inclusion.one_of(True, False) or not _is_known(polygon):
            continue
        places = [place for place in map(place_in, corners.elements(_MOST_CORNERS)) if place is not None]
        if len(places) >= 3:
            yield Zone(inclusion.value, tuple(places), None, polygon.at_text)
        elif isinstance(corners.value, list) and len(corners.value) < 3:
            corners.add_problem(f"has {counted(len(corners.value), 'corners')}; at least 3 are needed")


def _is_known(shape: Part) -> bool:
    version = shape.get("version")
    return version is None or version.one_of(_SHAPE_VERSION)


QGC_PLAN: Final = Importer("a QGroundControl plan", (".plan",), of_kind(FileKind.QGC_PLAN), _read)
