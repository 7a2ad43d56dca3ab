"""The mission file that is made from another tool's file."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator
from typing import Final

from waypointctl.display_text import printable
from waypointctl.errors import MissionError
from waypointctl.importers.importer import ImportedMission, Stop, Zone
from waypointctl.importers.local_frame import BODIES, EARTH, Body, Place, Point
from waypointctl.importers.placed import Placed, placed
from waypointctl.mission.files import parse_mission
from waypointctl.mission.format import quoted

_TIMEOUT_S: Final = 30.0
_HOME_TIMEOUT_S: Final = 300.0
_MOST_TIMEOUT_S: Final = 86_400.0
_SLOWEST_MPS: Final = 1.0
_WIDTH: Final = 120
_MOST_NAME: Final = 60  # characters of a waypoint's name


def mission_text(
    imported: ImportedMission, where: str, policy: str, origin: Place | None = None, body: Body | None = None
) -> tuple[str, Placed]:
    """Return the mission file made from another tool's file, and its places in metres.

    Args:
        imported: its content.
        where: the file, for messages and for the comment at the top.
        policy: the policy's folder, relative to the mission file.
        origin: where x and y are 0; where the robot starts if it is left out.
        body: that the places are on; the file's body if it is left out.

    Raises:
        MissionError: it does not fit in a mission: too wide, or beyond a limit.
    """
    ground = placed(imported, where, origin, body or BODIES[imported.body])
    if not ground.stops:
        raise MissionError("has no waypoint besides the start", where=where)
    text = "".join(f"{line}\n" for line in _lines(imported.name, ground, where, policy))
    parse_mission(text.encode(), f"{where} as a mission")
    return text, ground


def _lines(name: str, ground: Placed, where: str, policy: str) -> Iterator[str]:
    yield from (f"# {printable(line)}" for line in _head(ground, where))
    yield f"name: {quoted(name)}"
    yield f"policy: {quoted(policy)}"
    if any(ground.start):
        yield from ("", "start:", f"  position: {_pair(ground.start)}")
    if (timeout_s := _timeout_s(ground)) > _TIMEOUT_S:
        yield from ("", "defaults:", f"  timeout: {timeout_s:g} s")
    yield from ("", "waypoints:")
    for (stop, point), label in zip(ground.stops, _names(ground), strict=True):
        yield f"  - {_stop(stop, point, label)}"
    if ground.zones:
        yield from ("", "onboard:")
        yield from _fence(ground)


def _head(ground: Placed, where: str) -> Iterator[str]:
    if ground.frame is None:
        yield f"From {where!r}. x and y are those of the file, in metres."
    else:
        (latitude, longitude), body = ground.frame.origin, ground.frame.body
        on = "" if body == EARTH else f" on {body.name}"
        yield f"From {where!r}. x is east and y is north of {latitude:.7f}, {longitude:.7f}{on}."
    for note in ground.left_out:
        yield f"Left out: {note}"


def _fence(ground: Placed) -> Iterator[str]:
    yield "  geofence:"
    for keep_in in (True, False):
        wanted = [(zone, points) for zone, points in ground.zones if zone.keep_in == keep_in]
        if wanted:
            yield f"    {'keep_in' if keep_in else 'keep_out'}:"
            for zone, points in wanted:
                yield from _area(zone, points)
        if keep_in and len(wanted) > 1:
            yield "    keep_in_match: all"
    if ground.return_to is not None:
        yield "    do: return_home"
        reached = [ground.start, *(point for _, point in ground.stops)]
        timeout_s = _leg_timeout_s(max(math.dist(ground.return_to, point) for point in reached))
        timeout = f", timeout: {timeout_s:g} s" if timeout_s > _HOME_TIMEOUT_S else ""
        yield f"  home: {{position: {_pair(ground.return_to)}{timeout}}}"


def _area(zone: Zone, points: tuple[Point, ...]) -> Iterator[str]:
    if zone.radius_m is not None:
        yield f"      - {{center: {_pair(points[0])}, radius: {zone.radius_m:.10g} m}}"
        return
    corners = [f"[{x_m:.10g}, {y_m:.10g}]" for x_m, y_m in points]
    if len(in_one_line := f"      - {{corners: [{', '.join(corners)}]}}") <= _WIDTH:
        yield in_one_line
    else:
        yield "      - corners:"
        yield from (f"          - {corner}" for corner in corners)


def _stop(stop: Stop, point: Point, name: str) -> str:
    parts = [f"name: {quoted(name)}"] if name else []
    parts.append(f"position: {_pair(point)}")
    if stop.radius_m is not None:
        parts += ["acceptance: radius", f"tolerance: {stop.radius_m:.10g} m"]
    if stop.hold_s:
        parts.append(f"hold: {stop.hold_s:.10g} s")
    if stop.observe:
        parts.append("observe: true")
    return f"{{{', '.join(parts)}}}"


def _names(ground: Placed) -> Iterator[str]:
    """Yield the waypoints' names, no two alike; a waypoint without one is called WP1, WP2, ... by its place."""
    used = {f"WP{place}" for place, (stop, _) in enumerate(ground.stops, 1) if not stop.name}
    for stop, _ in ground.stops:
        base = printable(re.sub(r"\s+", " ", stop.name).strip(), _MOST_NAME)[:_MOST_NAME] if stop.name else ""
        name, count = base, 1
        while base and name in used:
            count += 1
            name = f"{base[: _MOST_NAME - 6]} {count}"
        used.add(name)
        yield name


def _timeout_s(ground: Placed) -> float:
    """Return the time that the longest leg gets."""
    points = [ground.start, *(point for _, point in ground.stops)]
    return _leg_timeout_s(max(math.dist(a, b) for a, b in itertools.pairwise(points)))


def _leg_timeout_s(way_m: float) -> float:
    """Return one and a half times what a way takes at 1 m/s, in whole tens of seconds."""
    return min(math.ceil(1.5 * way_m / _SLOWEST_MPS / 10) * 10.0, _MOST_TIMEOUT_S)


def _pair(point: Point) -> str:
    return f"[{point[0]:.10g} m, {point[1]:.10g} m]"
