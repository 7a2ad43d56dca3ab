"""What a map shows of a flight, under way or over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from waypointctl.log.setting import MissionSetting
from waypointctl.replay.return_home import ReturnHome
from waypointctl.replay.summary import WaypointSummary
from waypointctl.replay.track import IntArray, Track

if TYPE_CHECKING:
    from waypointctl.replay.summary import FlightSummary
    from waypointctl.replay.summary_builder import FlightSummaryBuilder


@dataclass(frozen=True, slots=True)
class Scene:
    """What a map shows.

    Attributes:
        truth: the path driven; the robot is at its end.
        waypoints: of the mission.
        belief: where the operator believes the robot to be, None before the first telemetry.
        setting: home, zones and contact windows.
        returns: the ways home.
        missing_ns: when each message was sent that did not arrive, (n,).
    """

    truth: Track
    waypoints: Sequence[WaypointSummary]
    belief: tuple[float, float] | None = None
    setting: MissionSetting = field(default_factory=MissionSetting)
    returns: Sequence[ReturnHome] = ()
    missing_ns: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def home(self) -> tuple[float, float] | None:
        """Where home is, where that matters."""
        home = self.setting.home_to_show(has_returned=bool(self.returns))
        return None if home is None else (home.x_m, home.y_m)


def scene_so_far(flight: FlightSummaryBuilder, most: int) -> Scene:
    """Return what a map shows of a flight under way, the way in about `most` points."""
    frame, link = flight.telemetry, flight.link.summary(flight.now_ns)
    believed = None if frame is None else (frame.x_m, frame.y_m)
    truth, returns = flight.truth(most), flight.returns
    return Scene(truth, flight.waypoints, believed, flight.setting, returns, link.missing_ns)


def scene_of(summary: FlightSummary, most: int) -> Scene:
    """Return what a map shows of a flight, the way in about `most` points."""
    last = summary.believed_at
    believed = (float(last.x_m[0]), float(last.y_m[0])) if len(last) else None
    truth, missing_ns = summary.truth.thinned(most), summary.link.missing_ns
    return Scene(truth, summary.waypoints, believed, summary.setting, summary.returns, missing_ns)
