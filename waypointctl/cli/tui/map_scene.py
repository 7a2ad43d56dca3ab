"""What a map shows of a flight, under way or over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from waypointctl.log.setting import MissionSetting
from waypointctl.replay.return_home import ReturnHome
from waypointctl.replay.story import WaypointStory
from waypointctl.replay.track import IntArray, Track

if TYPE_CHECKING:
    from waypointctl.replay.chronicle import Chronicle
    from waypointctl.replay.story import Story


@dataclass(frozen=True, slots=True)
class Scene:
    """What a map shows.

    Attributes:
        truth: the way walked; the robot is at its end.
        waypoints: of the mission.
        belief: where the operator believes the robot to be, None before it has heard of it.
        setting: home, zones and contact windows.
        returns: the ways home.
        missing_ns: when each message was sent that did not arrive, (n,).
    """

    truth: Track
    waypoints: Sequence[WaypointStory]
    belief: tuple[float, float] | None = None
    setting: MissionSetting = field(default_factory=MissionSetting)
    returns: Sequence[ReturnHome] = ()
    missing_ns: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))

    @property
    def home(self) -> tuple[float, float] | None:
        """Where home is, where that matters."""
        home = self.setting.home_to_show(has_returned=bool(self.returns))
        return None if home is None else (home.x_m, home.y_m)


def scene_so_far(chronicle: Chronicle, most: int) -> Scene:
    """Return what a map shows of a flight under way, the way in about `most` points."""
    frame, link = chronicle.telemetry, chronicle.link.story(chronicle.now_ns)
    believed = None if frame is None else (frame.x_m, frame.y_m)
    truth, returns = chronicle.truth(most), chronicle.returns
    return Scene(truth, chronicle.waypoints, believed, chronicle.setting, returns, link.missing_ns)


def scene_of(story: Story, most: int) -> Scene:
    """Return what a map shows of a flight, the way in about `most` points."""
    last = story.believed_at
    believed = (float(last.x_m[0]), float(last.y_m[0])) if len(last) else None
    truth, missing_ns = story.truth.thinned(most), story.link.missing_ns
    return Scene(truth, story.waypoints, believed, story.setting, story.returns, missing_ns)
