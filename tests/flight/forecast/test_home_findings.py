from __future__ import annotations

import pytest

from waypointctl.flight.forecast.home import home_findings
from waypointctl.mission.files import parse_mission

BASE = "name: n\npolicy: p\nwaypoints: [[8, 0], [30, 0]]\n"
SENT = "schedule: [{at: 2 s, do: return_home}]\n"
FENCE = "geofence: {keep_in: [{center: [0 m, 0 m], radius: 900 m}], do: return_home}"


def found(more: str) -> list[tuple[tuple[str | int, ...], str]]:
    mission = parse_mission(f"{BASE}{more}".encode(), "m.yaml")
    return [(each.path, each.text) for each in home_findings(mission, 2.0)]


@pytest.mark.parametrize(
    ("more", "text"),
    [
        (SENT + "onboard: {home: {position: [400 m, 0 m], timeout: 5 s}}\n", "WP2 takes about 185 s"),  # the nearest
        ("onboard: {on_failure: return_home, home: {timeout: 5 s}}\n", "WP2 takes about 15 s"),  # the farthest
        ("onboard: {link_loss: {after: 9 s, do: return_home}, home: {timeout: 5 s}}\n", "WP2 takes about 15 s"),
        (f"onboard: {{{FENCE}, home: {{timeout: 5 s}}}}\n", "WP2 takes about 15 s"),
    ],
)
def test_a_way_home_that_takes_too_long_is_found(more: str, text: str) -> None:
    assert found(more) == [(("onboard", "home", "timeout_s"), f"the way home from {text}; its timeout is 5 s")]


@pytest.mark.parametrize(
    "more",
    [
        SENT,
        "onboard: {home: {position: [400 m, 0 m], timeout: 5 s}}\n",  # nothing sends it there
        "onboard: {on_failure: return_home, home: {timeout: 15 s}}\n",
        "onboard: {geofence: {do: return_home}, home: {timeout: 5 s}}\n",  # there is no fence
        SENT + "onboard: {home: {timeout: 5 s}}\n",  # it may be sent while it is near: the schedule says when
    ],
)
def test_a_way_home_that_may_be_walked_is_not(more: str) -> None:
    assert found(more) == []
