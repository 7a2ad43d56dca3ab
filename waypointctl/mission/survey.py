"""What other tools' files say of a mission, in latitudes and longitudes, and the mission file that becomes of it."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from waypointctl.errors import MissionError
from waypointctl.mission.files import parse_mission
from waypointctl.mission.json_source import Part
from waypointctl.mission.layout.layout import laid_out
from waypointctl.mission.layout.write import quoted
from waypointctl.mission.local_frame import MAX_SPAN_M, LocalFrame, Place, Point, span_m

_MAX_LATITUDE: Final = 89.0  # beyond, a degree of longitude is no length any more
_TIMEOUT_S: Final = 30.0
_SLOWEST_MPS: Final = 1.0


@dataclass(frozen=True, slots=True)
class Stop:
    """A place to walk to.

    Attributes:
        place: latitude and longitude [deg].
        name: empty for none.
        hold_s: how long to stand there.
        radius_m: how near is there; None for the mission's default.
        observe: whether a picture is taken there.
    """

    place: Place
    name: str = ""
    hold_s: float = 0.0
    radius_m: float | None = None
    observe: bool = False


@dataclass(frozen=True, slots=True)
class Zone:
    """An area of a fence: a circle with a centre and a radius, or a polygon with corners."""

    keep_in: bool
    corners: tuple[Place, ...]  # of a circle its centre alone
    radius_m: float | None = None


@dataclass(frozen=True, slots=True)
class Survey:
    """What a file says.

    Attributes:
        name: of the mission.
        origin: where x and y are 0.
        start: where the robot stands when the mission starts.
        stops: in order.
        zones: of the fence.
        notes: what the file says beside, and is left out.
        order: how the file's format writes a place, where it is easily written the other way round.
    """

    name: str
    origin: Place
    start: Place
    stops: tuple[Stop, ...]
    zones: tuple[Zone, ...] = ()
    notes: tuple[str, ...] = ()
    order: str = ""

    @property
    def places(self) -> tuple[Place, ...]:
        """All places but the origin."""
        return (
            self.start,
            *(stop.place for stop in self.stops),
            *(place for zone in self.zones for place in zone.corners),
        )


def place_of(latitude: Part, longitude: Part) -> Place | None:
    """Return a place, None where it is none, which is reported."""
    north, east = latitude.number(-_MAX_LATITUDE, _MAX_LATITUDE), longitude.number(-180, 180)
    return None if north is None or east is None else (north, east)


def mission_name(text: str) -> str:
    """Return a text as a mission's name, which names files."""
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", text)[:80].strip("-._")
    return name or "imported"


def mission_text(survey: Survey, where: str, policy: str) -> str:
    """Return the mission file of what another tool's file says.

    Args:
        survey: what it says.
        where: the file, for messages and for the comment at the top.
        policy: the policy's folder, relative to the mission file.

    Raises:
        MissionError: it is no mission: too wide, or beyond what a mission may have.
    """
    frame = LocalFrame(survey.origin)
    span = span_m([frame.point(place) for place in (survey.origin, *survey.places)])
    if span > MAX_SPAN_M:
        problem = f"spans {span / 1000:.1f} km; the local frame is for at most {MAX_SPAN_M / 1000:g} km"
        mend = f"{survey.order}: see that they are not swapped. Else cut" if survey.order else "Cut"
        raise MissionError(problem, where=where, mend=f"{mend} it, or give an --origin near it.")
    text = "".join(f"{line}\n" for line in _lines(survey, frame, where, policy))
    parse_mission(text.encode(), f"{where} as a mission")
    return laid_out(text.encode(), where).decode()


def _lines(survey: Survey, frame: LocalFrame, where: str, policy: str) -> Iterator[str]:
    latitude, longitude = survey.origin
    yield f"# From {where!r}. x is east and y is north of {latitude:.7f}, {longitude:.7f}."
    yield f"# An equirectangular frame: no place is off by more than {_error_text(frame.error_m(survey.places))}."
    for note in survey.notes:
        yield f"# Left out: {note}"
    yield f"name: {quoted(survey.name)}"
    yield f"policy: {quoted(policy)}"
    if any(start := _rounded(frame.point(survey.start))):
        yield f"start: {{position: {_pair(start)}}}"
    if (timeout_s := _timeout_s(survey, frame)) > _TIMEOUT_S:
        yield f"defaults: {{timeout: {timeout_s:g} s}}"
    yield "waypoints:"
    for stop in survey.stops:
        yield f"  - {_stop(stop, frame)}"
    if survey.zones:
        yield "onboard:\n  geofence:"
        yield from _zones(survey.zones, frame, keep_in=True)
        yield from _zones(survey.zones, frame, keep_in=False)


def _stop(stop: Stop, frame: LocalFrame) -> str:
    parts = [f"name: {quoted(stop.name)}"] if stop.name else []
    parts.append(f"position: {_pair(_rounded(frame.point(stop.place)))}")
    if stop.radius_m is not None:
        parts += ["acceptance: radius", f"tolerance: {stop.radius_m:g} m"]
    if stop.hold_s:
        parts.append(f"hold: {stop.hold_s:g} s")
    if stop.observe:
        parts.append("observe: true")
    return f"{{{', '.join(parts)}}}"


def _zones(zones: tuple[Zone, ...], frame: LocalFrame, *, keep_in: bool) -> Iterator[str]:
    wanted = [zone for zone in zones if zone.keep_in == keep_in]
    if wanted:
        yield f"    {'keep_in' if keep_in else 'keep_out'}:"
    for zone in wanted:
        pairs = [_pair(_rounded(frame.point(place))) for place in zone.corners]
        if zone.radius_m is None:
            yield f"      - {{corners: [{', '.join(f'{{position: {pair}}}' for pair in pairs)}]}}"
        else:
            yield f"      - {{center: {pairs[0]}, radius: {zone.radius_m:g} m}}"


def _timeout_s(survey: Survey, frame: LocalFrame) -> float:
    """Return what the longest leg takes at a slow walk and a half, in whole tens of seconds."""
    points = [frame.point(place) for place in (survey.start, *(stop.place for stop in survey.stops))]
    longest_m = max(math.dist(a, b) for a, b in itertools.pairwise(points))
    return math.ceil(1.5 * longest_m / _SLOWEST_MPS / 10) * 10.0


def _rounded(point: Point) -> Point:
    """Return a point to the millimetre."""
    return round(point[0], 3) + 0.0, round(point[1], 3) + 0.0


def _pair(point: Point) -> str:
    return f"[{point[0]:.10g} m, {point[1]:.10g} m]"


def _error_text(error_m: float) -> str:
    return f"{max(math.ceil(error_m * 1000), 1)} mm" if error_m < 0.1 else f"{math.ceil(error_m * 100) / 100:g} m"
