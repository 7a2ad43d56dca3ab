"""The places, the geofence and the rally points of a QGroundControl plan (see qgroundcontrol.py for the format)."""

from __future__ import annotations

from collections.abc import Iterator

from waypointctl.mission.json_source import Part
from waypointctl.mission.local_frame import Place
from waypointctl.mission.survey import Zone, place_of
from waypointctl.mission.wording import counted


def place_in(part: Part) -> Place | None:
    """Return the place that a list [latitude, longitude, ...] says."""
    elements = list(part.elements())
    if len(elements) < 2:
        if isinstance(part.value, list):
            part.complain(f"has {counted(len(elements), 'numbers')}; latitude and longitude are needed")
        return None
    return place_of(elements[0], elements[1])


def zones_of(root: Part) -> Iterator[Zone]:
    """Yield the areas of a plan's fence; what is wrong with it is reported."""
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
        place = None if center is None else place_in(center)
        radius_m = None if radius is None else radius.number(0.001, 20_000)
        if place is not None and radius_m is not None:
            yield Zone(inclusion.value, (place,), radius_m)
    for polygon in fence.each("polygons"):
        inclusion, corners = polygon.at("inclusion"), polygon.at("polygon")
        if inclusion is None or corners is None or not inclusion.one_of(True, False):
            continue
        places = [place for place in (place_in(corner) for corner in corners.elements()) if place is not None]
        if len(places) >= 3:
            yield Zone(inclusion.value, tuple(places))
        elif isinstance(corners.value, list):
            corners.complain(f"has {counted(len(places), 'corners')}; at least 3 are needed")


def rally_points(root: Part) -> Iterator[Part]:
    """Yield the points that a plan's vehicle may retreat to."""
    rally = root.at("rallyPoints")
    if rally is not None:
        yield from rally.each("points")
