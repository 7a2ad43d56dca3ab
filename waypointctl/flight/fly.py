"""THE loop: a mission flown, tick by tick, with the link between operator and robot."""

from __future__ import annotations

from collections.abc import Callable

from waypointctl.flight.flight import Flight
from waypointctl.flight.navigator.navigator import Navigator
from waypointctl.flight.operator.console import LineSource
from waypointctl.flight.outcome import FlightResult
from waypointctl.flight.sink import Sink
from waypointctl.mission.mission import Mission
from waypointctl.policy.protocol import Policy
from waypointctl.robots.load import load_robot
from waypointctl.robots.robot import Robot


def fly(
    mission: Mission,
    policy: Policy,
    sink: Sink,
    *,
    robot: Robot | None = None,
    interrupted: Callable[[], bool] = lambda: False,
    console: LineSource | None = None,
    navigator: Navigator | None = None,
) -> FlightResult:
    """Fly a mission to its end and hand every message to the sink.

    Args:
        mission: what is asked.
        policy: the policy that drives the robot; made for the mission's robot.
        sink: takes each message as it happens.
        robot: the robot to fly, where it is not the shipped one (a log brings its own).
        interrupted: asked before every control step; True ends the flight.
        console: where a person's commands come from, if there is a person.
        navigator: gives the policy its goals; straight to the plan's waypoints where there is none.
    """
    flight = Flight(mission, policy, sink, robot or load_robot(mission.robot), console, navigator)
    flight.begin()
    while True:
        flight.exchange()
        flight.read_console()
        flight.sense()
        flight.exchange()
        if flight.over:
            return flight.end()
        if interrupted():
            return flight.interrupt()
        flight.act()
