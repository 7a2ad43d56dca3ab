from __future__ import annotations

import pytest

from waypointctl.flight.forecast.stuck import stuck_findings
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Mission

BASE = "name: n\npolicy: p\nwaypoints: [[8, 0]]\n"


def ruled(within: str, for_: str, more: str = "") -> Mission:
    text = f"{BASE}onboard: {{stuck: {{within: {within}, for: {for_}}}}}\n{more}"
    return parse_mission(text.encode(), "m.yaml")


@pytest.mark.parametrize(
    ("within", "for_", "text"),
    [
        (
            "1 m",
            "100 ms",
            "1 m in 0.1 s is 10.0 m/s, and the robot walks at 2.00 m/s: it counts as stuck on every leg; give it more "
            "than 0.9 s",
        ),
        (
            "1 m",
            "800 ms",
            "1 m in 0.8 s: a robot that stands takes 0.4 s to set out and 0.50 s for the way, and counts as stuck "
            "where it starts; give it more than 0.9 s",
        ),
    ],
)
def test_a_rule_that_no_robot_can_meet_is_found(within: str, for_: str, text: str) -> None:
    mission = ruled(within, for_)
    assert [(each.path, each.text) for each in stuck_findings(mission, 2.0)] == [(("onboard", "stuck"), text)]


@pytest.mark.parametrize(
    ("within", "for_", "more"), [("10 cm", "5 s", ""), ("1 m", "1 s", ""), ("1 m", "100 ms", "autonomy: joint\n")]
)
def test_a_rule_that_a_robot_meets_is_not(within: str, for_: str, more: str) -> None:
    mission = ruled(within, for_, more)
    assert list(stuck_findings(mission, 2.0)) == []
