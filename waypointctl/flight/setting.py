"""What a mission fixes before its flight, as views of the flight show it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from waypointctl.flight.executive.rules import home_of
from waypointctl.flight.link.build import contacts_of
from waypointctl.flight.link.contacts import FOREVER_NS, Contacts
from waypointctl.log.setting import ContactWindows, MissionSetting
from waypointctl.mission.geofence import zones_of
from waypointctl.mission.mission import Mission


def setting_of(mission: Mission) -> MissionSetting:
    """Return what a mission fixes.

    Raises:
        MissionError: a file that its link refers to is missing or broken.
    """
    onboard = mission.onboard
    return MissionSetting(
        home=home_of(mission),
        may_return=onboard.home.position_m is not None or "return_home" in _reactions(mission),
        zones=zones_of(onboard.geofence),
        up=_windows(contacts_of(mission.link.up, mission.files)),
        down=_windows(contacts_of(mission.link.down, mission.files)),
    )


def _reactions(mission: Mission) -> Iterator[str]:
    """Yield what the rules on board and the schedule make the robot do."""
    onboard = mission.onboard
    yield mission.failure_rule.then
    if onboard.link_loss is not None:
        yield onboard.link_loss.do
    if onboard.geofence.keep_in or onboard.geofence.keep_out:
        yield onboard.geofence.do
    yield from (command.do for command in mission.schedule)


def _windows(contacts: Contacts) -> ContactWindows | None:
    """Return when there is contact; None for a link that is always there."""
    begin_ns = np.array([window.begin_ns for window in contacts.windows], np.int64)
    end_ns = np.array([window.end_ns for window in contacts.windows], np.int64)
    if len(begin_ns) == 1 and (begin_ns[0], end_ns[0]) == (0, FOREVER_NS):
        return None
    return ContactWindows(begin_ns, end_ns, contacts.period_ns)
