"""What a mission may say can be flown: whatever validates is accepted on board, at the bounds of every number too."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.budget import examples
from waypointctl.flight.command_life import names
from waypointctl.flight.executive.rules import Fence, rules_of
from waypointctl.flight.executive.start import wrong_arguments
from waypointctl.flight.link.frames import size_bytes
from waypointctl.flight.operator.operator import Operator
from waypointctl.flight.operator.planner import MissionOperator, ShortRangeGoalOperator, WaypointOperator
from waypointctl.flight.operator.requests import CommandRequest, planned_waypoints, scheduled_requests
from waypointctl.log.messages import Command, CommandKind, Mode, Telemetry
from waypointctl.log.topics import BY_KIND
from waypointctl.mission import fields
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import MOST_LEGS, Mission

OPERATORS = {"mission": MissionOperator, "waypoint": WaypointOperator, "short_range_goal": ShortRangeGoalOperator}


def within(field: object) -> st.SearchStrategy[float]:
    """Return numbers that a field of a mission file takes, often the outermost ones."""
    bounds = fields.bounds_of(field)
    least = bounds.ge if bounds.ge is not None else math.nextafter(bounds.gt or 0.0, math.inf)
    assert bounds.le is not None
    ends = (least, bounds.le, math.nextafter(least, math.inf), math.nextafter(bounds.le, -math.inf))
    return st.sampled_from(ends) | st.floats(least, bounds.le)


coordinates, tolerances = within(fields.Coordinate), within(fields.Tolerance)
timeouts, holds = within(fields.Timeout), within(fields.Hold)
places = st.lists(coordinates, min_size=2, max_size=2)
waypoints = st.fixed_dictionaries(
    {"position_m": places},
    optional={
        "acceptance": st.sampled_from(["box", "radius"]),
        "tolerance_m": tolerances,
        "timeout_s": timeouts,
        "hold_s": holds,
        "observe": st.booleans(),
    },
)
moments = st.sampled_from([0.0, 1e-10, 1.0, 8_640_000.0]) | st.floats(0, 8_640_000)


@st.composite
def commands(draw: st.DrawFn, count: int) -> dict[str, Any]:
    do = draw(st.sampled_from(["go_to", "hold", "resume", "skip", "abort", "return_home", "set_tolerance", "release"]))
    command: dict[str, Any] = {"at_s": draw(moments), "do": draw(st.sampled_from([do, "set_timeout"]))}
    match command["do"]:
        case "go_to":
            command |= {"position_m": draw(places), "tolerance_m": draw(tolerances), "timeout_s": draw(timeouts)}
        case "set_tolerance":
            command["tolerance_m"] = draw(tolerances)
        case "set_timeout":
            command["timeout_s"] = draw(timeouts)
        case "release":
            command["released"] = draw(st.integers(-1, count))
    if draw(st.booleans()):
        command["not_before_s"] = draw(moments)
    least = math.nextafter(max(command["at_s"], command.get("not_before_s", 0.0)), math.inf)
    if least <= 8_640_000 and draw(st.booleans()):
        command["expires_s"] = draw(st.just(least) | st.floats(least, 8_640_000))
    return command


@st.composite
def missions(draw: st.DrawFn) -> Mission:
    given_waypoints = draw(st.lists(waypoints, min_size=1, max_size=5))
    repeat = draw(st.sampled_from([1, 2, 1000]))
    count = repeat * len(given_waypoints)
    mission = {
        "name": "n",
        "policy": "p",
        "waypoints": given_waypoints,
        "repeat": repeat,
        "start": {"position_m": draw(places)},
        "autonomy": draw(st.sampled_from(sorted(OPERATORS))),
        "operator": {"released": draw(st.integers(-1, count)), "lookahead_m": draw(st.floats(0.1, 100))},
        "on_failure": {"then": draw(st.sampled_from(["abort", "skip", "hold", "return_home"]))},
        "schedule": draw(st.lists(commands(count), max_size=4)),
    }
    return parse_mission(json.dumps(mission).encode(), "m.yaml")


def orders_of(mission: Mission) -> Iterator[CommandRequest]:
    """Yield all that the ground sends by itself: what the operator begins with, all waypoints, the schedule."""
    yield from OPERATORS[mission.autonomy](mission).begin()
    for waypoint in planned_waypoints(mission)[:20]:
        yield CommandRequest(CommandKind.GO_TO, (waypoint,))
    yield from (order for _, order in scheduled_requests(mission).entries())


@settings(max_examples=examples(60), deadline=None)
@given(missions())
def test_whatever_validates_is_accepted_on_board_and_fits_a_log(mission: Mission) -> None:
    for order in orders_of(mission):
        command = order.command(1, 1, 0, 2**62)
        assert wrong_arguments(command, Fence()) == ""
        assert size_bytes(command) > 0
        topic = BY_KIND[Command]
        assert topic.decode(topic.encode(command)) == command


@settings(max_examples=examples(60), deadline=None)
@given(places, places, st.floats(-50, 50), st.floats(0.1, 100))
def test_a_goal_ahead_of_a_robot_at_the_edge_is_accepted_too(
    at: list[float], to: list[float], beyond_m: float, lookahead_m: float
) -> None:
    """The robot overshoots, and its goals lie between where it is and its waypoint."""
    text = {
        "name": "n",
        "policy": "p",
        "autonomy": "short_range_goal",
        "waypoints": [to],
        "operator": {"lookahead_m": lookahead_m},
    }
    operator: Operator = ShortRangeGoalOperator(parse_mission(json.dumps(text).encode(), "m.yaml"))
    operator.begin()
    operator.on_message(
        0, Telemetry(0, Mode.NAVIGATING, at[0] + beyond_m, at[1] - beyond_m, 0.5, 0.0, 1.0, -1, (), 0, 0)
    )
    assert isinstance(operator, ShortRangeGoalOperator)
    command = operator._lookahead_goal().command(1, 1, 0, 0)
    assert wrong_arguments(command, Fence()) == ""


@pytest.mark.parametrize("count", [1, 999, 1000, 1001, MOST_LEGS])
def test_a_plan_of_as_many_legs_as_a_mission_may_have_is_accepted(count: int) -> None:
    legs = 1 if count % 10 else 10
    text = {"name": "n", "policy": "p", "waypoints": [[1, 0]] * legs, "repeat": min(count // legs, 1000)}
    mission = parse_mission(json.dumps(text).encode(), "m.yaml")
    (order,) = MissionOperator(mission).begin()
    more = planned_waypoints(mission)
    command = CommandRequest(order.kind, (more * (count // len(more) + 1))[:count]).command(1, 1, 0, 0)
    assert wrong_arguments(command, Fence()) == ""
    assert len(names(command.waypoints)) < 2000, "a text names few of them"


def test_no_time_is_so_short_that_a_rule_is_switched_off() -> None:
    text = "name: n\npolicy: p\nwaypoints: [[1, 0]]\nonboard: {link_loss: {after_s: 1.0e-12}}\n"
    assert rules_of(parse_mission(text.encode(), "m.yaml")).link_loss_ns == 1
