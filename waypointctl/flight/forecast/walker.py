"""A robot on paper: the executive that flies, on a point that walks straight on at the policy's mean speed."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.flight.executive.executive import Executive
from waypointctl.flight.executive.rules import rules_of
from waypointctl.flight.forecast.tolerance import NEAREST_M
from waypointctl.flight.link.frames import Heartbeat
from waypointctl.flight.news import News
from waypointctl.log.messages import FINAL_STAGES, Ack, Command, CommandStage, Event, Stage, Telemetry
from waypointctl.mission.mission import Mission
from waypointctl.units import NS_PER_S, ns

FloatArray = NDArray[np.float64]

# Until a standing ant is under way: 0.42 s are left of a goal's time in docs/delay.md (heading, move and wait) once the
# way and the round trip are taken from it.
SETTING_OUT_S: Final = 0.4
_SETTING_OUT_NS: Final = ns(SETTING_OUT_S)
_TINY_M: Final = 1e-9
_REST_AFTER_NS: Final = 10 * NS_PER_S  # as in flight: so long still, then frames come at the beacon's rate
_TOLD_WITH_A_FRAME: Final = FINAL_STAGES - {Stage.REJECTED, Stage.SKIPPED}


def _ignore(_: Event) -> None:
    return


class Walker:
    """One robot that obeys commands; it does not fall, and misses no waypoint that it comes to.

    Attributes:
        executive: what decides on board.
        news: which frame was the first to tell how it stands.
    """

    def __init__(self, mission: Mission, speed_mps: float, send: Callable[[int, Ack | Telemetry], None]) -> None:
        """Stand at the mission's start; `send` takes what it reports at a time [ns]."""
        rules = rules_of(mission)
        self.executive = Executive(self._report, _ignore, remind=self._acknowledge, rules=rules)
        self._fence = rules.fence
        self.news = News()
        self._send = send
        self._speed_mps = speed_mps
        self._position = np.array([mission.start.position_m], dtype=np.float64)  # (1, 2) [m]
        self._period_ns = ns(1 / mission.telemetry.rate_hz)
        self._beacon_ns = max(ns(mission.telemetry.beacon_s), self._period_ns)
        self._frames = 0
        self._frame_ns = 0  # when the next frame is due
        self._stood_ns = 0  # when it last stood
        self._moved_ns = 0  # when it last walked

    def obey(self, now_ns: int, arrived: Command | Heartbeat) -> None:
        """Take what has arrived."""
        if isinstance(arrived, Heartbeat):
            self.executive.heard(now_ns)
            return
        self.executive.obey(now_ns, arrived)
        self._tell(now_ns)

    def sense(self, now_ns: int) -> None:
        """Let the executive look at the world; report at the telemetry rate and whenever something changes."""
        self.executive.sense(now_ns, self._position, fell=False)
        if now_ns >= self._frame_ns:
            self._tell(now_ns)
            self._frame_ns = now_ns + (self._beacon_ns if self.is_still(now_ns) else self._period_ns)
        elif self.news.differ(self.executive):
            self._tell(now_ns)

    def walk(self, now_ns: int, until_ns: int) -> None:
        """Walk on for a while, or stand."""
        if not self.executive.on_foot:
            self._stood_ns = until_ns
            return
        if self._has_rested(now_ns):
            self._frame_ns = now_ns
        self._moved_ns = until_ns
        walked_ns = until_ns - max(now_ns, self._stood_ns + _SETTING_OUT_NS)
        if walked_ns <= 0:
            return
        way = self.executive.goals[0, 0] - self._position[0]
        left_m = math.hypot(*way)
        step_m = self._speed_mps * walked_ns / NS_PER_S
        step = way * (min(step_m, left_m - NEAREST_M) / left_m if left_m > NEAREST_M else 0.0)
        self._position[0] = self._watched(self._position[0], self._position[0] + step)

    def _watched(self, start: FloatArray, end: FloatArray) -> FloatArray:
        """Return where a step (2,) [m] ends: no step is so long that it leads across a fence unseen."""
        (ax, ay), (bx, by) = start.tolist(), end.tolist()
        if self._fence.breach(ax, ay):
            return end
        place = self._fence.first_breach((ax, ay), (bx, by))
        return end if place is None else np.array(place)

    def is_still(self, now_ns: int) -> bool:
        """Tell whether it has stood for so long that it rests."""
        return not self.executive.on_foot and self._has_rested(now_ns)

    def _has_rested(self, now_ns: int) -> bool:
        return now_ns - self._moved_ns >= _REST_AFTER_NS

    def next_ns(self, now_ns: int) -> int:
        """Return when it has something to do by itself, standing [ns]."""
        due_ns = self.executive.next_ns(now_ns)
        return self._frame_ns if due_ns is None else min(due_ns, self._frame_ns)

    def _tell(self, now_ns: int) -> None:
        executive, target = self.executive, self.executive.target
        index = -1 if target is None else target.index
        x_m, y_m = self._position[0].tolist()
        pose = (x_m or _TINY_M, y_m or _TINY_M, 0.55, 0.75, 2.0)  # a 0 takes no bytes: frames are as long as in flight
        told = executive.statuses, executive.cause
        frame = Telemetry(self._frames, executive.mode, *pose, index, executive.reached, now_ns, now_ns, *told)
        self._frames += 1
        self.news.sent(frame)
        self._send(now_ns, frame)

    def _report(self, stage: CommandStage) -> None:
        if stage.stage in _TOLD_WITH_A_FRAME:
            self._tell(stage.time_ns)
        self._acknowledge(stage)

    def _acknowledge(self, it: CommandStage) -> None:
        self._send(it.time_ns, Ack(it.command_id, it.stage, it.reason, it.time_ns, it.time_ns))
