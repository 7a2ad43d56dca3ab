"""The geofence of a QGroundControl plan (see qgroundcontrol.py for the format).

Inclusions of a plan are one group of MAVLink's: the vehicle has to be inside all of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.importers.json_source import Part, is_unset, place_in
from waypointctl.importers.local_frame import Place
from waypointctl.importers.report import Report
from waypointctl.importers.survey import Zone
from waypointctl.mission.wording import counted

_VERSION: Final = 2
_SHAPE_VERSION: Final = 1
_AREAS: Final = ("circles", "polygons", "circle", "polygon")  # the last two are of version 1
_MOST_RADIUS_M: Final = 20_000.0
_MOST_AREAS: Final = 100  # as many as a mission's geofence holds
_MOST_CORNERS: Final = 1000
_MOST_CORNERS_IN_ALL: Final = 3_000


def read_fence(root: Part, report: Report) -> tuple[tuple[Zone, ...], Place | None]:
    """Return the areas of a plan's fence, and where a vehicle goes that breaks it; what is wrong is reported."""
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
    if version is not None and not version.one_of(_VERSION):
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
