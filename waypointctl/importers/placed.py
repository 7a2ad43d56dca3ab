"""A imported in metres: where its places are in the local frame, and which of them are too far away."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

from pydantic import ValidationError

from waypointctl.errors import MissionError
from waypointctl.importers.importer import MOST_STOPS, ImportedMission, Report, Stop, Zone
from waypointctl.importers.local_frame import Body, LocalFrame, Place, Point, span_m, thinned
from waypointctl.mission.onboard import Area

_HERE_M: Final = 0.5  # as near as a waypoint is reached: a take-off this near is at the robot's place


@dataclass(frozen=True, slots=True)
class Placed:
    """A imported's places in metres."""

    frame: LocalFrame | None  # that they are in; None where the file has metres itself
    start: Point  # x and y [m] where the robot starts
    stops: tuple[tuple[Stop, Point], ...]  # with their places
    zones: tuple[tuple[Zone, tuple[Point, ...]], ...]  # with their corners
    return_to: Point | None  # where the robot goes when it breaks the fence
    left_out: tuple[str, ...]  # what is left out, in words


def placed(imported: ImportedMission, where: str, origin: Place | None, body: Body) -> Placed:
    """Return a imported in metres.

    Args:
        imported: the content of a file.
        where: the file, for messages.
        origin: of the frame; where the robot starts if it is left out.
        body: that the places are on.

    Raises:
        MissionError: its places are too far apart, or there is neither a start nor an origin.
    """
    if imported.is_metric:
        return _in_frame(imported, where, None)
    if imported.start is None and origin is None:
        hint = _origin_hint(imported)
        raise MissionError(f"{imported.start_at} is missing", where=where, hint=f"Give the place of the start: {hint}.")
    center = origin or imported.start
    assert center is not None
    frame = LocalFrame(center, body)
    if origin is not None and imported.is_home and not _is_near(imported.start, frame):
        imported = _started_at(imported, origin)
    _refuse_too_wide(imported, where, frame, origin)
    return _in_frame(imported, where, frame)


def _is_near(place: Place | None, frame: LocalFrame) -> bool:
    return place is not None and span_m([(0.0, 0.0), frame.point(place)]) <= frame.max_span_m


def _started_at(imported: ImportedMission, origin: Place) -> ImportedMission:
    """Return a imported whose robot starts at the origin in place of a home that is missing or far away."""
    note: tuple[str, ...] = ()
    if imported.start is not None:
        note = (f"{imported.start_at} {_text(imported.start)}: far from --origin; the robot starts at --origin",)
    return replace(imported, start=origin, left_out=(*imported.left_out, *note))


def _in_frame(imported: ImportedMission, where: str, frame: LocalFrame | None) -> Placed:
    def point(place: Place) -> Point:
        x_m, y_m = place if frame is None else frame.point(place)
        return round(x_m, 3) + 0.0, round(y_m, 3) + 0.0  # to the millimetre

    start = (0.0, 0.0) if imported.start is None else point(imported.start)
    stops = [(stop, start if stop.place is None else point(stop.place)) for stop in imported.stops]
    left_out = imported.left_out
    if imported.is_line and len(stops) > MOST_STOPS:
        stops, note = _thinned(stops, start, where)
        left_out = (*left_out, note)
    zones = tuple((zone, tuple(map(point, zone.corners))) for zone in imported.zones)
    _refuse_wrong_zones(zones, where)
    return Placed(
        frame,
        start,
        tuple(_on_the_way(stops, start)),
        zones,
        None if imported.return_to is None else point(imported.return_to),
        left_out,
    )


def _thinned(stops: list[tuple[Stop, Point]], start: Point, where: str) -> tuple[list[tuple[Stop, Point]], str]:
    """Return as many places of a long line as its course needs, and what is left out, in words."""
    named = [place for place, (stop, _) in enumerate(stops, 1) if stop.name]
    kept = thinned([start, *(point for _, point in stops)], named, _HERE_M, MOST_STOPS + 1)
    rule = f"within {_HERE_M:g} m of the straight way between the others"
    if kept is None:
        problem = f"has {len(stops) + 1:,} positions, and more than {MOST_STOPS:,} even without those {rule}"
        limit = f"a mission has at most {MOST_STOPS:,} waypoints"
        raise MissionError(f"{problem}; {limit}", where=where, hint="Simplify it, or cut it into several.")
    dropped = f"{len(stops) + 1 - len(kept):,} of {len(stops) + 1:,} positions"
    return [stops[place - 1] for place in kept[1:]], f"{dropped}: {rule}"


def _on_the_way(stops: list[tuple[Stop, Point]], start: Point) -> Iterator[tuple[Stop, Point]]:
    """Yield stops without those that need a way and have none; what is done there is done at the one before."""
    kept: list[tuple[Stop, Point]] = []
    for stop, point in stops:
        before = kept[-1][1] if kept else start
        if not stop.needs_way or math.dist(before, point) > _HERE_M:
            kept.append((stop, point))
        elif kept:
            last = kept[-1][0]
            merged = replace(last, hold_s=last.hold_s + stop.hold_s, observe=last.observe or stop.observe)
            kept[-1] = (merged, kept[-1][1])
        elif stop.hold_s or stop.observe:
            kept.append((stop, point))
    yield from kept


def _named(imported: ImportedMission) -> Iterator[tuple[str, tuple[Place, ...]]]:
    """Yield the places of an import, with their positions in the file."""
    if imported.start is not None:
        yield imported.start_at, (imported.start,)
    for stop in imported.stops:
        if stop.place is not None:
            yield stop.at, (stop.place,)
    for zone in imported.zones:
        yield zone.at, zone.corners
    if imported.return_to is not None:
        yield "geoFence.breachReturn", (imported.return_to,)


def _refuse_too_wide(imported: ImportedMission, where: str, frame: LocalFrame, origin: Place | None) -> None:
    """Refuse places that are further apart than the frame holds, and name those that make it so."""
    groups = [(name, places, [frame.point(place) for place in places]) for name, places in _named(imported)]
    whole_m = span_m([(0.0, 0.0), *(point for _, _, points in groups for point in points)])
    if whole_m <= frame.max_span_m:
        return
    limit = f"the local frame is for at most {frame.max_span_m / 1000:g} km"
    wide = [(name, span_m(points)) for name, _, points in groups if span_m(points) > frame.max_span_m]
    if wide:
        problem = "; ".join(f"{name} spans {_km(extent_m)}" for name, extent_m in wide[:3])
        raise MissionError(f"{problem}; {limit}", where=where, hint="Draw it smaller, or take it out of the file.")
    path = [points[0] for name, _, points in groups if not (imported.is_home and name == imported.start_at)]
    points = path or [(0.0, 0.0)]
    middle = (statistics.median(x for x, _ in points), statistics.median(y for _, y in points))
    far = [(name, places[0]) for name, places, group in groups if span_m([middle, *group]) > frame.max_span_m]
    if origin is not None and span_m([middle, (0.0, 0.0)]) > frame.max_span_m:
        problem = f"--origin {_text(origin)}: some {_rough_km(math.hypot(*middle))} away from the places of the file"
        hint = _order(imported, f"Give an origin near them: {_origin_hint(imported)}.")
        raise MissionError(f"{problem}; {limit}", where=where, hint=hint)
    if far and len(far) <= len(groups) / 2:
        more = f" and {len(far) - 1} more" if len(far) > 1 else ""
        away_m = math.dist(middle, frame.point(far[0][1]))
        problem = f"{far[0][0]} {_text(far[0][1])}{more}: some {_rough_km(away_m)} away from the other places"
        is_home = imported.is_home and far[0][0] == imported.start_at
        hint = f"Give the place of the start: {_origin_hint(imported)}." if is_home else "See whether it is right."
        raise MissionError(f"{problem}; {limit}", where=where, hint=_order(imported, hint))
    hint = _order(imported, "Cut it, or give an --origin near it.")
    raise MissionError(f"spans {_km(whole_m)}; {limit}", where=where, hint=hint)


def _order(imported: ImportedMission, hint: str) -> str:
    return f"{imported.order}: see that they are not swapped. Else: {hint}" if imported.order else hint


def _origin_hint(imported: ImportedMission) -> str:
    place = next((stop.place for stop in imported.stops if stop.place is not None), None) or (47.3977, 8.5456)
    return f"--origin {place[0]:.7f},{place[1]:.7f}"


def _refuse_wrong_zones(zones: tuple[tuple[Zone, tuple[Point, ...]], ...], where: str) -> None:
    report = Report(where)
    for zone, points in zones:
        shape = (
            {"corners": [{"position_m": point} for point in points]}
            if zone.radius_m is None
            else {"center_m": points[0], "radius_m": zone.radius_m}
        )
        try:
            Area.model_validate(shape)
        except ValidationError as error:
            report.add_problem(zone.at, error.errors()[0]["msg"].removeprefix("Value error, "))
    report.refuse()


def _rough_km(length_m: float) -> str:
    """Return a length with two significant digits: far away a local frame is not more exact."""
    return f"{float(f'{length_m / 1000:.2g}'):,.0f} km"


def _km(length_m: float) -> str:
    return f"{length_m / 1000:,.1f} km"


def _text(place: Place) -> str:
    return f"({place[0]:.7g}, {place[1]:.7g})"
