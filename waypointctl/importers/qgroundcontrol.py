"""QGroundControl's .plan: its waypoints, its geofence and its rally points.

The format: https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html. Surveys and corridor scans
are walked along the simple items that QGroundControl laid them out as, a landing pattern along its two places.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.importers.json_source import Part, is_number, is_unset, place_in, read_json
from waypointctl.importers.local_frame import Place
from waypointctl.importers.mavlink import LAND, LOITER_TO_ALTITUDE, VTOL_LAND
from waypointctl.importers.mavlink_way import PARAMETERS, Item, follow
from waypointctl.importers.plan_fence import read_fence
from waypointctl.importers.report import Report, number_of
from waypointctl.importers.survey import Survey, mission_name
from waypointctl.mission.wording import shown

_RELATIVE: Final = 3  # MAV_FRAME of altitudes above the home
_PATTERNS: Final = {"fwLandingPattern": LAND, "vtolLandingPattern": VTOL_LAND}
_OLD_PARAMETERS: Final = 4  # beside a 'coordinate', in the first plans


def read_plan(source: bytes, report: Report, name: str) -> Survey:
    """Read a plan.

    Args:
        source: the file's bytes.
        report: what is wrong with it goes there.
        name: of the mission.

    Raises:
        MissionError: a walking robot cannot follow it, with all that is wrong.
    """
    root = read_json(source, report)
    mission = _mission_of(root)
    home = _home(mission)
    stops = follow(list(_items(mission)), report)
    zones, return_to = read_fence(root, report)
    if not stops and report.is_clean:
        mission.add_problem("has no waypoint to walk to: at least one item of command 16 is needed")
    report.refuse()
    if rally := _rally_count(root):
        report.left_out[f"rally point{'s' if rally > 1 else ''}: the robot has one home, onboard.home"] += rally
    return Survey(
        mission_name(name),
        home,
        stops,
        start_at="mission.plannedHomePosition",
        is_home=True,
        zones=zones,
        return_to=return_to,
        left_out=report.left_out_lines,
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
    """Yield the simple items that stand for a complex one; one that has none is reported."""
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
