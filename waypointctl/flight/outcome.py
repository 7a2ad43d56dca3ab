"""When a flight is over, and what it has come to as the operator knows it.

It ends when everything on board is over and the operator knows it or can receive nothing more: a plan, the return home,
a hold that ends by itself, a command that is kept for its time or is still under way. Whether anything is under way is
read from the true state of robot and link; the outcome follows from the operator's knowledge alone.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from waypointctl.flight.executive.executive import Executive
from waypointctl.flight.executive.rules import AT_HOME, FALL, GEOFENCE, LEG_FAILED, LINK_LOST, RETURN_FAILED, home_of
from waypointctl.flight.executive.state_machine import POLICY_MODES
from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.frames import Heartbeat
from waypointctl.flight.operator.station import Station
from waypointctl.flight.reporter import TelemetryChanges
from waypointctl.log.messages import Ack, Mode, Telemetry
from waypointctl.mission.mission import Mission
from waypointctl.units import ns, seconds

DEAF_AFTER: Final = 1000  # lost frames with the same content: then the next is not awaited

SILENT: Final = "the robot is at rest, and the operator has nothing left to send or to receive"
NO_COMMAND_FOLLOWED: Final = ", and no command followed"
_CUT_SHORT: Final = (GEOFENCE, LINK_LOST)  # by these a plan fails of which every waypoint may have been reached
_NEARLY: Final = 1.5  # times home's tolerance: the robot moves on a little after it stops driving


@dataclass(frozen=True, slots=True)
class EndCondition:
    """Decides whether a flight is over."""

    station: Station  # the ground
    executive: Executive  # on board
    changes: TelemetryChanges  # which frame of telemetry is the first with the robot's current state
    up: Direction[Any]  # the link to the robot
    down: Direction[Any]  # the link to the ground
    is_still: Callable[[int], bool]  # whether the robot is at rest at a time [ns]

    def is_done(self, now_ns: int) -> bool:
        """Return whether the operator has ended the mission, and all that was begun on board is over."""
        return self.station.finished and self._is_quiet(now_ns) and self._is_reported(now_ns)

    def is_silent(self, now_ns: int) -> bool:
        """Return whether nothing more can happen: the robot is at rest, and nothing is sent or received."""
        if not self.is_still(now_ns) or self.station.console_is_open or not self.station.is_idle:
            return False
        if not self._is_quiet(now_ns):
            return False
        if self.station.operator.acts_on_states and not (self.down.is_dead(now_ns) or self.up.is_dead(now_ns)):
            return False
        return self._is_reported(now_ns) and not any(isinstance(one, Ack) for _, one in self.down.under_way)

    def _is_quiet(self, now_ns: int) -> bool:
        """Return whether nothing is active on board, and no message under way or to be sent changes that."""
        executive = self.executive
        if executive.mode is Mode.FALLEN:
            return True
        if executive.plans or any(not isinstance(one, Heartbeat) for _, one in self.up.under_way):
            return False
        gives_up_ns = executive.gives_up_ns
        if gives_up_ns is not None and not self._is_contacted_before(now_ns, gives_up_ns):
            return False
        return not (executive.waits_for_ground and self._is_contacted(now_ns))

    def _is_contacted(self, now_ns: int) -> bool:
        """Return whether any message, if only a heartbeat, will reach the robot."""
        beats = self.station.heartbeats.next_ns is not None and not self.up.is_dead(now_ns)
        return beats or self.up.next_arrival_ns is not None

    def _is_contacted_before(self, now_ns: int, time_ns: int) -> bool:
        """Return whether a message will reach the robot before a time [ns], unless the link loses it."""
        arrival_ns, next_ns_ = self.up.next_arrival_ns, self.station.heartbeats.next_ns
        if arrival_ns is None and next_ns_ is not None and not self.up.is_dead(now_ns):
            arrival_ns = self.up.latest_arrival_ns(next_ns_, 1)
        return arrival_ns is not None and arrival_ns <= time_ns

    def _is_reported(self, now_ns: int) -> bool:
        """Return whether the operator knows the robot's current state, or can no longer receive it."""
        if self.changes.reported_in(self.station.operator.reported.telemetry):
            return True
        if not self.down.is_dead(now_ns) and self.changes.newest - self.changes.first < DEAF_AFTER:
            return False
        return not any(isinstance(one, Telemetry) and self.changes.reported_in(one) for _, one in self.down.under_way)


@dataclass(frozen=True, slots=True)
class FlightResult:
    """How a flight ended, as the operator knows it.

    Attributes:
        outcome: "success", "failure" or "interrupted".
        reason: why, in a few words.
        waypoints_reached: known to the operator.
        waypoints_total: in the mission.
        sim_time_ns: when the flight ended, on the operator's clock, from mission start.
        known_ns: when the operator knew how the mission had gone; what was begun on board may have gone on.
        seed: of everything random in it.
        pictures: how many were taken.
        no_pictures: why none was taken, and how to fix that; empty where none was missed.
        log: the path of its log, if it was written.
        log_sha256: of the log's bytes.
    """

    outcome: str
    reason: str
    waypoints_reached: int
    waypoints_total: int
    sim_time_ns: int
    known_ns: int
    seed: int
    pictures: int = 0
    no_pictures: str = ""
    log: Path | None = None
    log_sha256: str = ""

    def logged(self, path: Path) -> FlightResult:
        """Return the result of a flight whose log is closed."""
        with path.open("rb") as file:
            return replace(self, log=path, log_sha256=hashlib.file_digest(file, "sha256").hexdigest())


def result_of(mission: Mission, station: Station, ended_ns: int, known_ns: int | None, *, late: bool) -> FlightResult:
    """Return how a flight ended.

    Args:
        mission: the mission.
        station: the ground at the end.
        ended_ns: when it ended [ns].
        known_ns: when the operator had ended the mission [ns]; None where it has not.
        late: whether the mission's longest time was up first.
    """
    total, reached, reported = mission.num_legs, len(station.operator.reached), station.operator.reported
    told_ns = ended_ns if known_ns is None else known_ns
    where = last_known_place(mission, reported.telemetry, went_home=reported.went_home)
    limit_s = mission.expect.max_time_s
    late = late or (limit_s is not None and known_ns is not None and known_ns > ns(limit_s))
    problem, expected = problem_of(mission, station, over=known_ns is not None, late=late)
    facts = _facts(station, total, ended_ns, told_ns, expected, late=late)
    if problem:
        reason = f"{problem}: {facts}{'; ' * bool(where)}{where}"
        return FlightResult("failure", reason, reached, total, ended_ns, told_ns, mission.seed)
    reason = f"{facts}; {where}" if reported.went_home else facts
    return FlightResult("success", reason, reached, total, ended_ns, told_ns, mission.seed)


def _facts(station: Station, total: int, ended_ns: int, told_ns: int, expected: str, *, late: bool) -> str:
    """Return how many waypoints are known to be reached; and when that was, or both times where the flight went on."""
    reached, known, ended = len(station.operator.reached), f"{seconds(told_ns):.2f} s", f"{seconds(ended_ns):.2f} s"
    flew_on = late or station.operator.reported.went_home or reached < total
    if known == ended or not flew_on:
        return f"{reached} of {total} waypoints reached in {known}{expected}"
    times = f"the operator received the end of the plan at {known}; the flight ended at {ended}"
    return f"{reached} of {total} waypoints reached{expected}; {times}"


def problem_of(mission: Mission, station: Station, *, over: bool, late: bool) -> tuple[str, str]:
    """Return why a mission failed, empty if it did not, and what was expected of it, where that explains it."""
    operator, total = station.operator, mission.num_legs
    reached, frame = len(operator.reached), operator.reported.telemetry
    wanted = total if mission.expect.reached == "all" else mission.expect.reached
    waiting = standing_reason(mission, frame)
    if late:
        why = waiting or (station.missing if station.dispatcher.unanswered and not over else "")
        return f"the mission took longer than {mission.expect.max_time_s:g} s" + (f"; {why}" if why else ""), ""
    expected = f", {wanted} expected"
    if operator.failure == FALL or (frame is not None and frame.mode is Mode.FALLEN):
        return FALL, expected
    if not over and (waiting or reached < wanted):
        return waiting + NO_COMMAND_FOLLOWED if waiting else station.missing or SILENT, ""
    if reached < wanted:
        return operator.failure or "not all reached", expected
    if frame is not None and frame.cause.startswith(RETURN_FAILED):
        return frame.cause, ""
    if wanted == total and operator.failure in _CUT_SHORT:
        return operator.failure, ""
    return "", ""


def standing_reason(mission: Mission, frame: Telemetry | None) -> str:
    """Return what a stopped robot with open commands waits for; empty for any other."""
    if frame is None:
        return ""
    if frame.mode is Mode.PAUSED:
        return "the robot holds by command"
    if frame.mode is Mode.WAITING:
        return f"the robot waits for the release of {_next_name(mission, frame)}"
    return _why_safe(mission, frame) if frame.mode is Mode.SAFE else ""


def _why_safe(mission: Mission, frame: Telemetry) -> str:
    """Return which rule on board stopped the robot."""
    if frame.cause.startswith(AT_HOME):
        return f"a rule on board sent the robot home ({frame.cause.removeprefix(AT_HOME)})"
    if frame.cause.startswith(LEG_FAILED):
        return f"the robot holds after a failed leg at {_next_name(mission, frame)}"
    if frame.cause.startswith(GEOFENCE):
        return f"the robot holds by its {frame.cause}"
    if frame.cause == LINK_LOST:
        return "the robot holds because the link is lost"
    return "the robot holds because of a rule on board"


def last_known_place(mission: Mission, frame: Telemetry | None, *, went_home: bool) -> str:
    """Return where the robot is, as far as the ground knows, or what one in motion last reported; empty without.

    Args:
        mission: the mission.
        frame: the newest telemetry that has arrived.
        went_home: whether the ground knows of a return home.
    """
    if frame is None:
        return ""
    place = f"at ({frame.x_m:.2f}, {frame.y_m:.2f}) m"
    if frame.mode is Mode.FALLEN:
        return f"the robot has fallen {place}"
    if frame.mode in POLICY_MODES:
        return f"last telemetry: {frame.mode}, {place}"
    home = home_of(mission)
    away_m = math.dist((frame.x_m, frame.y_m), (home.x_m, home.y_m))
    is_home = frame.cause.startswith(AT_HOME) or (went_home and away_m <= _NEARLY * home.tolerance_m)
    return f"the robot is at home, {place}" if is_home else f"the robot is {place}"


def _next_name(mission: Mission, frame: Telemetry) -> str:
    """Return the robot's target waypoint; without one in the frame, the first that it has not reached."""
    names = {leg.index: leg.name for leg in mission.legs()}
    if frame.target in names:
        return names[frame.target]
    return next((name for index, name in names.items() if index not in frame.reached), "its waypoint")
