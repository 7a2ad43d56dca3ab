"""The rules on board: what the robot does by itself, without asking the ground."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from waypointctl.flight.executive.fence import Area, Circle, Fence, Polygon
from waypointctl.log.messages import PlannedWaypoint
from waypointctl.mission.geofence import Area as AreaModel
from waypointctl.mission.mission import Mission
from waypointctl.mission.onboard import Home
from waypointctl.units import ns, whole_ns

# Why a command was rejected or has failed: the reason in acknowledgements.
TIMEOUT: Final = "timeout"
STUCK: Final = "stuck"
FALL: Final = "fall"
GEOFENCE: Final = "geofence"
LINK_LOST: Final = "link lost"
FLIGHT_ENDED: Final = "flight ended"

# Why the robot is stopped: the cause in telemetry. Each goes before a code or, for a leg, a waypoint's name and a code.
AT_HOME: Final = "at home: "
RETURN_FAILED: Final = "way home given up: "
LEG_FAILED: Final = "leg failed: "

HOME_INDEX: Final = -1  # index of the return home, which is not a waypoint of the mission
_HOME: Final = Home()


def home_at(x_m: float, y_m: float, home: Home = _HOME) -> PlannedWaypoint:
    """Return the way home as a waypoint."""
    timeout_ns = ns(home.timeout_s)
    return PlannedWaypoint(HOME_INDEX, "home", x_m, y_m, "radius", home.tolerance_m, timeout_ns, hold_ns=0)


@dataclass(frozen=True, slots=True)
class Rules:
    """What the robot does by itself.

    Attributes:
        home: where it returns to.
        retries: how often a leg that failed is begun again.
        then: what follows when a leg has failed for good, unless its command sets it: "abort", "skip", "hold" or
            "return_home".
        slip_m: a waypoint at most this far away counts as reached once the robot gets no closer; 0 for never.
        progress_m: a smaller decrease of the distance is not progress.
        stall_ns: without progress for this long, the robot gets no closer.
        stuck_fails: whether a leg fails when the robot gets no closer.
        link_loss_ns: without anything from the ground for this long, the link is lost; 0 for never.
        on_link_loss: "finish" what has been released, "hold" or "return_home".
        fence: where it may be.
        on_breach: "hold", "return_home" or "abort".
    """

    home: PlannedWaypoint = field(default_factory=lambda: home_at(0.0, 0.0))
    retries: int = 0
    then: str = "abort"
    slip_m: float = 0.0
    progress_m: float = 0.1
    stall_ns: int = 5_000_000_000
    stuck_fails: bool = False
    link_loss_ns: int = 0
    on_link_loss: str = "finish"
    fence: Fence = field(default_factory=Fence)
    on_breach: str = "hold"

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
