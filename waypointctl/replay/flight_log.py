"""The flight that a log holds: its name, its waypoints, its summary."""

from __future__ import annotations

from waypointctl.errors import MissionError
from waypointctl.flight.header import MISSION, MISSION_FOLDER, files_within
from waypointctl.flight.operator.operator import planned_waypoints
from waypointctl.flight.setting import setting_of
from waypointctl.log.messages import PlannedWaypoint
from waypointctl.log.reader import Log
from waypointctl.log.setting import MissionSetting
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.replay.summary import FlightSummary
from waypointctl.replay.summary_builder import summarize


def mission_name(log: Log) -> str:
    """Return the name of the mission that was flown."""
    return log.metadata.get("mission") or log.path.stem


def waypoints_in(log: Log) -> tuple[PlannedWaypoint, ...]:
    """Return the mission's waypoints; none where the log carries no mission that can be read."""
    mission = _mission_in(log)
    return () if mission is None else planned_waypoints(mission)


def setting_in(log: Log) -> MissionSetting:
    """Return what the mission had fixed; nothing where the log carries no mission that can be read."""
    mission = _mission_in(log)
    try:
        return MissionSetting() if mission is None else setting_of(mission)
    except MissionError:
        return MissionSetting()


def summary_of(log: Log) -> FlightSummary:
    """Return the summary of a log's flight.

    Raises:
        LogError: a message cannot be read.
    """
    return summarize(log.messages(), waypoints_in(log), setting_in(log))


def summary_of_events(log: Log) -> FlightSummary:
    """Return what a log's events alone say of its flight: outcome, end, console. Quick, and in any log.

    Raises:
        LogError: an event cannot be read.
    """
    return summarize(log.messages(("/event",)))


def _mission_in(log: Log) -> Mission | None:
    source = log.attachments.get(MISSION)
    if source is None:
        return None
    try:
        return parse_mission(source, f"{log.path}/{MISSION}", files_within(MISSION_FOLDER, log.attachments))
    except MissionError:
        return None  # the summary is then told of the waypoints that were commanded; the proof names what is wrong
