"""The rules on board: what the robot does by itself, without asking the ground; and where it may be, the geofence."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final, TypeAlias

from waypointctl.log.messages import PlannedWaypoint
from waypointctl.mission.mission import Mission
from waypointctl.mission.onboard import Area as AreaModel
from waypointctl.mission.onboard import Home
from waypointctl.units import NS_PER_S, ns, whole_ns

Point: TypeAlias = tuple[float, float]

# Why a command was rejected or has failed: the reason in acknowledgements.
TIMEOUT: Final = "timeout"
STUCK: Final = "stuck"
FALL: Final = "fall"
GEOFENCE: Final = "geofence"
LINK_LOST: Final = "link lost"

# Why the robot is stopped: the cause in telemetry. Each goes before a code or, for a leg, a waypoint's name and a code.
AT_HOME: Final = "at home: "
RETURN_FAILED: Final = "way home given up: "
LEG_FAILED: Final = "leg failed: "

OBSERVATION_NS: Final = NS_PER_S  # how long the robot stops for a picture
HOME_INDEX: Final = -1  # index of the return home, which is not a waypoint of the mission
_HOME: Final = Home()


@dataclass(frozen=True, slots=True)
class Circle:
    """A round area: centre (x, y) and radius [m]."""

    name: str
    center_m: Point
    radius_m: float

    def holds(self, point: Point) -> bool:
        """Return whether a point [m] is in it."""
        return math.dist(point, self.center_m) <= self.radius_m

    def crossings(self, start: Point, end: Point) -> Iterator[float]:
        """Yield where the way from `start` to `end` meets the border, as fractions of the way."""
        dx, dy = end[0] - start[0], end[1] - start[1]
        fx, fy = start[0] - self.center_m[0], start[1] - self.center_m[1]
        a, half_b = dx * dx + dy * dy, fx * dx + fy * dy
        root = half_b * half_b - a * (fx * fx + fy * fy - self.radius_m * self.radius_m)
        if a > 0 and root >= 0:
            yield (-half_b - math.sqrt(root)) / a
            yield (-half_b + math.sqrt(root)) / a


@dataclass(frozen=True, slots=True)
class Polygon:
    """An area with straight borders: its corners (x, y) [m] in either direction, the last joined to the first.

    Where it crosses itself, what an odd number of borders encloses is in it.
    """

    name: str
    corners_m: tuple[Point, ...]

    def holds(self, point: Point) -> bool:
        """Return whether a point [m] is in it."""
        x, y = point
        inside = False
        for (ax, ay), (bx, by) in self._edges():
            side = (bx - ax) * (y - ay) - (by - ay) * (x - ax)  # > 0: left of the edge
            if side == 0 and min(ax, bx) <= x <= max(ax, bx) and min(ay, by) <= y <= max(ay, by):
                return True
            # An edge counts where it passes the point's height: upward if the point is left of it, or downward
            # if right. Its lower end belongs to it and its upper end does not, so a corner counts once.
            if (ay <= y < by and side > 0) or (by <= y < ay and side < 0):
                inside = not inside
        return inside

    def crossings(self, start: Point, end: Point) -> Iterator[float]:
        """Yield where the way from `start` to `end` meets the border, as fractions of the way."""
        dx, dy = end[0] - start[0], end[1] - start[1]
        for (ax, ay), (bx, by) in self._edges():
            ex, ey = bx - ax, by - ay
            across = dx * ey - dy * ex
            if across != 0:
                along_edge = ((ax - start[0]) * dy - (ay - start[1]) * dx) / across
                if 0 <= along_edge <= 1:
                    yield ((ax - start[0]) * ey - (ay - start[1]) * ex) / across

    def _edges(self) -> Iterator[tuple[Point, Point]]:
        return pairwise((*self.corners_m, self.corners_m[0]))


Area: TypeAlias = Circle | Polygon


@dataclass(frozen=True, slots=True)
class Fence:
    """What the robot is to stay in and out of. A fence without areas has room for everything."""

    keep_in: tuple[Area, ...] = ()
    keep_out: tuple[Area, ...] = ()
    keep_in_all: bool = False  # whether the robot has to be in every area of keep_in; else one is enough

    def breach(self, x_m: float, y_m: float) -> str:
        """Return how a place breaks the fence, as "is outside keep-in"; empty if it does not."""
        point = (x_m, y_m)
        outside = [area for area in self.keep_in if not area.holds(point)]
        if self.keep_in_all and outside:
            return f"is outside keep-in {outside[0].name}"
        if outside and len(outside) == len(self.keep_in):
            return "is outside keep-in"
        return next((f"is inside keep-out {area.name}" for area in self.keep_out if area.holds(point)), "")

    def breach_between(self, start: Point, end: Point) -> str:
        """Return how the straight way between two places [m] breaks the fence; empty if it does not."""
        place = self.first_breach(start, end)
        return "" if place is None else self.breach(*place)

    def first_breach(self, start: Point, end: Point) -> Point | None:
        """Return a place [m] in the first part of the straight way that breaks the fence; None if none does."""
        areas = (*self.keep_in, *self.keep_out)
        meets = sorted(at for area in areas for at in area.crossings(start, end) if 0 < at < 1)
        cuts = [0.0, *meets, 1.0]
        parts = [0.0, *((a + b) / 2 for a, b in pairwise(cuts)), 1.0]
        places = (_between(start, end, at) for at in parts)
        return next((place for place in places if self.breach(*place)), None)


def crosses(breach: str) -> str:
    """Return what a path that breaks the fence does, from the text of `breach`: "crosses keep-out 1"."""
    return breach.replace("is inside", "crosses").replace("is outside", "leaves")


def _between(start: Point, end: Point, at: float) -> Point:
    return start[0] + at * (end[0] - start[0]), start[1] + at * (end[1] - start[1])


def home_at(x_m: float, y_m: float, home: Home = _HOME) -> PlannedWaypoint:
    """Return the way home as a waypoint."""
    timeout_ns = ns(home.timeout_s)
    return PlannedWaypoint(HOME_INDEX, "home", x_m, y_m, "radius", home.tolerance_m, timeout_ns, hold_ns=0)


@dataclass(frozen=True, slots=True)
class Rules:
    """What the robot does by itself."""

    home: PlannedWaypoint = field(default_factory=lambda: home_at(0.0, 0.0))  # where it returns to
    retries: int = 0  # how often a leg that failed is begun again
    # What follows when a leg has failed for good, unless its command sets it: "abort", "skip", "hold" or
    # "return_home"
    then: str = "abort"
    slip_m: float = 0.0  # a waypoint at most this far away counts as reached once the robot gets no closer; 0 for never
    progress_m: float = 0.1  # a smaller decrease of the distance is not progress
    stall_ns: int = 5_000_000_000  # without progress for this long, the robot gets no closer
    stuck_fails: bool = False  # whether a leg fails when the robot gets no closer
    link_loss_ns: int = 0  # without anything from the ground for this long, the link is lost; 0 for never
    on_link_loss: str = "finish"  # "finish" what has been released, "hold" or "return_home"
    fence: Fence = field(default_factory=Fence)  # where it may be
    on_breach: str = "hold"  # "hold", "return_home" or "abort"

    @property
    def watches_progress(self) -> bool:
        """Whether anything follows from getting no closer."""
        return self.stuck_fails or self.slip_m > 0


def rules_of(mission: Mission) -> Rules:
    """Return the rules that a mission loads into the robot."""
    onboard, failure = mission.onboard, mission.failure_rule
    loss = onboard.link_loss
    return Rules(
        home=home_of(mission),
        retries=failure.retry,
        then=failure.then,
        slip_m=onboard.stopped_tolerance_m,
        progress_m=onboard.progress.within_m,
        stall_ns=ns(onboard.progress.for_s),
        stuck_fails=onboard.stuck is not None,
        link_loss_ns=0 if loss is None else whole_ns(loss.after_s),
        on_link_loss="finish" if loss is None else loss.do,
        fence=fence_of(mission),
        on_breach=onboard.geofence.do,
    )


def home_of(mission: Mission) -> PlannedWaypoint:
    """Return the mission's home position: its start, unless the mission sets another."""
    home = mission.onboard.home
    return home_at(*(home.position_m or mission.start.position_m), home)


def fence_of(mission: Mission) -> Fence:
    """Return a mission's geofence."""
    model = mission.onboard.geofence
    return Fence(_areas(model.keep_in), _areas(model.keep_out), keep_in_all=model.keep_in_match == "all")


def _areas(models: tuple[AreaModel, ...]) -> tuple[Area, ...]:
    return tuple(_area(model, model.name or str(place)) for place, model in enumerate(models, 1))


def _area(model: AreaModel, name: str) -> Area:
    if model.corners is not None:
        return Polygon(name, tuple(corner.position_m for corner in model.corners))
    assert model.center_m is not None
    assert model.radius_m is not None
    return Circle(name, model.center_m, model.radius_m)
