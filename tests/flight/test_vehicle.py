"""A robot on its own: actions from the ground, and their absence."""

from __future__ import annotations

import numpy as np

from tests.flight.flying import STILL, Scripted
from waypointctl.flight.executive.rules import Rules
from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.frames import BodyFrame, ControlFrame, LoggedDirection
from waypointctl.flight.reporter import Reporter
from waypointctl.flight.vehicle import Vehicle
from waypointctl.log.messages import Ack, Message, Mode, Telemetry
from waypointctl.mission.fields import Start
from waypointctl.robots.load import load_robot
from waypointctl.task.config import draw_start
from waypointctl.units import NS_PER_S


def vehicle() -> Vehicle:
    messages: list[Message] = []
    downlink = LoggedDirection(Direction[Ack | Telemetry | BodyFrame](), "down", messages.append)
    robot = load_robot("ant")
    reporter = Reporter(downlink, NS_PER_S, NS_PER_S, every_state=True)
    made = Vehicle(robot, Scripted(STILL), messages.append, reporter, Rules())
    made.place(*draw_start(Start(), robot, np.random.default_rng(0)), np.zeros(4))
    return made


def test_a_robot_without_actions_from_the_ground_stands_after_a_minute() -> None:
    robot = vehicle()
    robot.execute(NS_PER_S, ControlFrame(0, STILL, 0, NS_PER_S))
    for now_ns, mode in ((61 * NS_PER_S - 1, Mode.TELEOPERATED), (61 * NS_PER_S, Mode.IDLE)):
        robot.sense(now_ns)
        assert robot.executive.mode is mode
        assert robot.is_still(now_ns) is (mode is Mode.IDLE)


def test_an_action_that_arrives_out_of_order_is_ignored() -> None:
    robot = vehicle()
    robot.execute(NS_PER_S, ControlFrame(5, STILL + 0.5, 0, NS_PER_S))
    robot.execute(30 * NS_PER_S, ControlFrame(4, STILL, 0, 30 * NS_PER_S))
    robot.sense(61 * NS_PER_S)
    assert robot.executive.mode is Mode.IDLE, "the newest action is a minute old"
