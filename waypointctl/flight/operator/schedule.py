"""The mission's scheduled commands, as orders."""

from __future__ import annotations

from collections.abc import Sequence

from waypointctl.flight.operator.agenda import Agenda
from waypointctl.flight.operator.operator import LOOKAHEAD
from waypointctl.flight.operator.order import Order
from waypointctl.log.messages import CommandKind, PlannedWaypoint
from waypointctl.mission.mission import Mission
from waypointctl.mission.schedule import ScheduledCommand
from waypointctl.units import ns, whole_ns


def agenda_of(mission: Mission) -> Agenda[Order]:
    """Return the mission's scheduled commands, each at its time."""
    agenda: Agenda[Order] = Agenda()
    for scheduled in mission.schedule:
        agenda.note(ns(scheduled.at_s), order_of(scheduled, mission))
    return agenda


def order_of(scheduled: ScheduledCommand, mission: Mission) -> Order:
    """Return a scheduled command as an order; what a place leaves open is taken from the mission's defaults."""
    return Order(
        kind=CommandKind(scheduled.do),
        waypoints=() if scheduled.position_m is None else (place(scheduled.position_m, mission, scheduled),),
        released=-1 if scheduled.released is None else scheduled.released,
        target_id=-1 if scheduled.command is None else scheduled.command,
        value=_value(scheduled),
        not_before_ns=-1 if scheduled.not_before_s is None else ns(scheduled.not_before_s),
        expires_ns=-1 if scheduled.expires_s is None else ns(scheduled.expires_s),
    )


def place(position_m: Sequence[float], mission: Mission, scheduled: ScheduledCommand | None = None) -> PlannedWaypoint:
    """Return a place that is none of the mission's waypoints, (x, y) in [m]."""
    defaults = mission.defaults
    tolerance_m = scheduled.tolerance_m if scheduled else None
    timeout_s = scheduled.timeout_s if scheduled else None
    hold_s = scheduled.hold_s if scheduled else None
    return PlannedWaypoint(
        index=LOOKAHEAD,
        name=f"({position_m[0]:g}, {position_m[1]:g})",
        x_m=position_m[0],
        y_m=position_m[1],
        acceptance=defaults.acceptance,
        tolerance_m=defaults.tolerance_m if tolerance_m is None else tolerance_m,
        timeout_ns=whole_ns(defaults.timeout_s if timeout_s is None else timeout_s),
        hold_ns=ns(defaults.hold_s if hold_s is None else hold_s),
    )


def _value(scheduled: ScheduledCommand) -> float:
    if scheduled.do == "set_tolerance":
        return scheduled.tolerance_m or 0.0
    return scheduled.timeout_s or 0.0 if scheduled.do == "set_timeout" else 0.0
