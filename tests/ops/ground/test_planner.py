from __future__ import annotations

import pytest

from waypointctl.log.messages import CommandKind
from waypointctl.mission.files import parse_mission
from waypointctl.ops.ground.planner import MissionOperator

TEXT = "name: n\npolicy: p\nwaypoints: [[1, 2], [3, 4]]\n"


@pytest.mark.parametrize(
    ("more", "released"), [("", -1), ("operator: {released: 1}\n", 1), ("operator: {released: 0}\n", 0)]
)
def test_a_plan_is_released_as_far_as_the_mission_says(more: str, released: int) -> None:
    (order,) = MissionOperator(parse_mission((TEXT + more).encode(), "m.yaml")).begin()
    assert (order.kind, len(order.waypoints), order.released) == (CommandKind.UPLOAD_PLAN, 2, released)
