from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from tests.flight.flying import mission_of
from waypointctl.flight.checks import Finding
from waypointctl.flight.checks.check import cannot_succeed, check_mission
from waypointctl.flight.fly import fly
from waypointctl.mission.files import load_mission, parse_mission
from waypointctl.policy.bundle import load_policy

ROOT = Path(__file__).parents[3]
ONE = "waypoints: [[8, 6]]\n"
TWO = "waypoints: [[8, 6], [8, 16]]\n"
PIT = "onboard: {geofence: {keep_out: [{name: pit, center: [%s], radius: 1 m}]}}\n"
HOME_IN_PIT = (PIT % "40 m, 3 m").replace("}}\n", "}, home: {position: [40 m, 3 m]}}\n")
CORNER = "waypoints: [{position: [10 m, 0 m], tolerance: %g m}, [10, 10]]\n" + PIT % "8.2 m, 3 m"
LOST_AFTER_5_S = "onboard: {link_loss: {after: 5 s}}\n"
FINE = "waypoints: [{position: [8 m, 6 m], tolerance: 1 mm}]\n"
EVERY_10_S = "link: {up: {windows: [{from: 0 s, to: %d s}], windows_period: 10 s}}\n"
UP, DOWN = "link: {up: {%s}}\n", "link: {down: {%s}}\n"
STEERED = "autonomy: short_range_goal\noperator: {steering: continuous, update_rate: 5 Hz}\n"
HOME_3_S = "home: {timeout: 3 s}}\n"
KEEP_IN = "onboard: {geofence: {keep_in: [{center: [0 m, 0 m], radius: %d m}]}}\n"
LATE = "link: {delay: 2 s}\nexpect: {max_time: 30 s}\n"


def found(text: str, files: dict[str, bytes] | None = None) -> list[Finding]:
    mission = parse_mission(f"name: n\npolicy: p\n{text}".encode(), "m.yaml", files or {})
    return list(check_mission(mission, speed_mps=2.0))


def kinds(text: str, files: dict[str, bytes] | None = None) -> list[tuple[str, str]]:
    return [(finding.kind, ".".join(map(str, finding.path))) for finding in found(text, files)]


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        (ONE + PIT % "4 m, 3 m", [("fence", "waypoints.0")]),
        (ONE + PIT % "8 m, 6 m", [("fence", "waypoints.0")]),
        (ONE + PIT % "0 m, 0 m", [("fence", "start")]),
        (ONE + PIT % "40 m, 3 m", []),
        (ONE + HOME_IN_PIT, [("fence", "onboard.home.position_m")]),
        (CORNER.replace("%g", "3"), [("fence", "waypoints.1")]),
        (CORNER.replace("%g", "0.5"), []),
        (
            TWO + "defaults: {timeout: 4 s}\nrepeat: 9\n",
            [("timeout", "waypoints.0.timeout_s"), ("timeout", "waypoints.1.timeout_s")],
        ),
        (ONE + "defaults: {timeout: 4 s}\non_failure: {retry: 1}\n", [("timeout", "waypoints.0.timeout_s")]),
        (ONE + "defaults: {timeout: 5 s}\n", []),
        ("waypoints: [[0.4, 0.4]]\n", [("near", "waypoints.0")]),
        ("waypoints: [{position: [0.4 m, 0.4 m], acceptance: radius}]\n", []),
        ("waypoints: [[5, 5], [5.9, 5]]\n", [("near", "waypoints.1")]),
        ("waypoints: [[5, 5], [6.1, 5]]\n", []),
        ("waypoints: [[5, 5], {position: [6.1 m, 5 m], tolerance: 70 cm}]\n", [("near", "waypoints.1")]),
        (FINE, [("tolerance", "waypoints.0.tolerance_m")]),
        (FINE + "onboard: {stopped_tolerance: 30 cm}\n", []),
        (
            ONE + "schedule: [{at: 1 s, do: set_tolerance, tolerance: 1 mm}]\n",
            [("tolerance", "schedule.0.tolerance_m")],
        ),
        (ONE + "expect: {max_time: 4 s}\n", [("max_time", "expect.max_time_s")]),
        (ONE + "expect: {max_time: 5 s}\n", []),
        (ONE + "expect: {max_time: 5 s}\nlink: {delay: 1 s}\n", [("max_time", "expect.max_time_s")]),
    ],
)
def test_what_may_go_wrong_on_the_route_is_found(more: str, expected: list[tuple[str, str]]) -> None:
    assert kinds(more) == expected


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ("schedule: [{at: 2 s, do: return_home}]\nonboard: {home: {position: [400 m, 0 m], timeout: 5 s}}\n", True),
        ("onboard: {on_failure: return_home, home: {timeout: 3 s}}\n", True),
        ("onboard: {link_loss: {after: 90 s, do: return_home}, home: {timeout: 3 s}}\n", True),
        ("onboard: {geofence: {keep_in: [{center: [0 m, 0 m], radius: 900 m}], do: return_home}, " + HOME_3_S, True),
        ("onboard: {geofence: {do: return_home}, " + HOME_3_S, False),  # there is no fence
        ("schedule: [{at: 2 s, do: return_home}]\nonboard: {home: {timeout: 3 s}}\n", False),  # it may be near then
        ("onboard: {home: {position: [400 m, 0 m], timeout: 5 s}}\n", False),  # nothing sends it there
        ("onboard: {on_failure: return_home, home: {timeout: 15 s}}\n", False),
    ],
)
def test_a_way_home_that_takes_too_long_is_found(more: str, expected: bool) -> None:
    assert (("timeout", "onboard.home.timeout_s") in kinds(TWO + more)) == expected


@pytest.mark.parametrize(
    ("do", "expected"), [("onboard: {on_failure: return_home, %s}\n", True), ("onboard: {%s}\n", False)]
)
def test_a_way_home_through_the_fence_is_found(do: str, expected: bool) -> None:
    route = "waypoints: [[0, 8], [8, 8]]\n"
    fence = do % "geofence: {keep_out: [{center: [4 m, 4 m], radius: 1 m}]}"
    assert kinds(route + fence) == [("fence", "onboard.geofence")] * expected


@pytest.mark.parametrize(
    ("rule", "expected"),
    [("within: 1 m, for: 800 ms", True), ("within: 10 cm, for: 5 s", False), ("within: 1 m, for: 1 s", False)],
)
def test_a_stuck_rule_that_no_robot_meets_is_found(rule: str, expected: bool) -> None:
    assert kinds(f"{ONE}onboard: {{stuck: {{{rule}}}}}\n") == [("stuck", "onboard.stuck")] * expected


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        (
            UP % "windows: [{from: 1 s, to: 3 s}, {from: 5 s, to: 50 s}], rate: 300 bit/s",
            [("contact", "link.up.windows")],
        ),
        (UP % "windows: [{from: 5 s, to: 50 s}], rate: 300 bit/s", []),
        (UP % "windows: [{from: 1 s, to: 3 s}], rate: 200 bit/s", [("contact", "link.up.windows")]),
        (UP % "windows: [{from: 5 s, to: 50 s}], queue: 10 B", [("queue", "link.up.queue_bytes")]),
        (UP % "queue: 10 B", []),  # a message that need not wait needs no queue
        (
            UP % "windows: [{from: 0 s, to: 5 s}, {from: 9 s, to: 50 s}], queue: 10 B",
            [("queue", "link.up.queue_bytes")],
        ),
        (UP % "windows: [{from: 0 s, to: 5 s}], windows_period: 9 s, queue: 10 B", [("queue", "link.up.queue_bytes")]),
        (DOWN % "queue: 10 B", []),
        (DOWN % "queue: 70 B, rate: 9600 bit/s", [("queue", "link.down.queue_bytes")]),
        (DOWN % "rate: 1 kbit/s", [("rate", "link.down.rate_bps")]),
        (DOWN % "rate: 10 kbit/s", []),
        (
            DOWN % "rate: 8 kbit/s, windows: [{from: 0 s, to: 1 s}], windows_period: 4 s",
            [("rate", "link.down.rate_bps")],
        ),
        (DOWN % "windows: [{from: 0 s, to: 1 s}]", [("contact", "link.down.windows")]),
        (DOWN % "windows: [{from: 0 s, to: 1 s}], windows_period: 4 s", []),
        (DOWN % "windows: [{from: 0 s, to: 50 s}]", []),
        (
            "link: {up: {windows: [{from: 60 s, to: 99 s}]}, down: {windows: [{from: 0 s, to: 50 s}]}}\n",
            [("contact", "link.down.windows")],
        ),
        ("link: {loss: 1}\n", [("loss", "link.up.loss")]),
        ("link: {down: {loss: 100 %}}\n", [("loss", "link.down.loss")]),
        ("link: {loss: {p: 1, r: 1, one_minus_h: 1, one_minus_k: 1}}\n", [("loss", "link.up.loss")]),
        ("link: {down: {loss: {p: 2 %, r: 0}}}\n", [("loss", "link.down.loss")]),
        ("link: {loss: 0.99}\n", []),
        ("link: {loss: {p: 0.5, r: 0, one_minus_h: 0.9}}\n", []),
        ("link: {loss: {p: 0, r: 0}}\n", []),
        ("autonomy: joint\nlink: {delay: 20 ms}\n", [("delay", "autonomy")]),
        ("autonomy: joint\nlink: {delay: 19 ms}\n", []),
        ("autonomy: joint\nrobot: ./other\nlink: {delay: 20 ms}\n", []),  # the study flew the ant
        (STEERED, []),
        (STEERED + "link: {delay: 1 s}\n", [("steering", "operator.lookahead_m")]),
        ("autonomy: short_range_goal\nlink: {delay: 1 s}\n", []),
        ("onboard: {link_loss: {after: 2 s}}\n", [("heartbeat", "onboard.link_loss")]),
        ("onboard: {link_loss: {after: 60 s}}\n", []),  # the mission is over by then
        ("onboard: {link_loss: {after: 2 s}}\nautonomy: joint\n", []),
        (LOST_AFTER_5_S + "operator: {heartbeat: 1 s}\n", []),
        (LOST_AFTER_5_S + "operator: {heartbeat: 5 s}\n", [("heartbeat", "onboard.link_loss")]),
        (LOST_AFTER_5_S + "operator: {heartbeat: 1 s}\n" + EVERY_10_S % 4, [("heartbeat", "onboard.link_loss")]),
        (LOST_AFTER_5_S + "operator: {heartbeat: 1 s}\n" + EVERY_10_S % 6, []),
    ],
)
def test_what_may_go_wrong_on_the_link_is_found(more: str, expected: list[tuple[str, str]]) -> None:
    assert kinds(ONE + more) == expected


def test_contacts_of_a_plan_that_are_too_short_are_found_at_the_plan() -> None:
    plan = b"a contact +0 +9 1 2 100\na contact +0 +3 2 1 10\na range +0 +9 1 2 1\n"
    text = ONE + "telemetry: {rate: 0.1 Hz}\nlink: {contact_plan: {file: plan, from_node: 1, to_node: 2}}\n"
    assert ("contact", "link.down.contact_plan") in kinds(text, {"plan": plan})


@pytest.mark.parametrize(
    ("more", "command", "field"),
    [
        (LATE, "at: 31 s, do: hold", "at_s"),
        (LATE, "at: 29 s, do: skip", "at_s"),
        (LATE, "at: 1 s, do: hold, not_before: 40 s", "not_before_s"),
        (LATE, "at: 1 s, do: hold, expires: 2 s", "expires_s"),
        ("link: {up: {windows: [{from: 0 s, to: 9 s}]}}\n", "at: 10 s, do: skip", "at_s"),
        ("", "at: 10 s, do: hold", "do"),  # nothing ends it
        ("autonomy: waypoint\n", "at: 1 s, do: release, released: 1", "do"),
        ("autonomy: short_range_goal\n", "at: 1 s, do: release, released: 1", "do"),
        ("autonomy: joint\n", "at: 1 s, do: skip", "do"),
        ("autonomy: joint\n", "at: 1 s, do: set_tolerance, tolerance: 1 m", "do"),
        ("autonomy: joint\n", "at: 1 s, do: set_timeout, timeout: 9 s", "do"),
        ("autonomy: joint\n", "at: 1 s, do: abort", "do"),
        (LATE, "at: 28 s, do: hold", ""),  # arrives as the flight ends
        (LATE, "at: 1 s, do: hold, not_before: 30 s", ""),
        (LATE, "at: 1 s, do: set_timeout, timeout: 60 s, expires: 3 s", ""),
        ("autonomy: joint\nexpect: {max_time: 60 s}\n", "at: 1 s, do: hold", ""),
        (KEEP_IN % 30, "at: 60 s, do: go_to, position: [5 m, 19 m]", ""),
    ],
)
def test_scheduled_commands_without_effect_are_found(more: str, command: str, field: str) -> None:
    expected = [("schedule", f"schedule.0.{field}")] if field else []
    assert kinds(f"{TWO}{more}schedule: [{{{command}}}]\n") == expected


def test_a_hold_without_a_resume_is_found_with_how_the_mission_ends() -> None:
    (finding,) = found(f"{TWO}schedule: [{{at: 5 s, do: hold}}]\n")
    assert finding.text == "if the robot is under way at 5 s, the mission fails: no resume follows this hold"


def test_a_scheduled_place_outside_the_fence_is_found() -> None:
    text = f"{TWO}{KEEP_IN % 20}schedule: [{{at: 1 s, do: go_to, position: [5 m, 21 m]}}]\n"
    assert kinds(text) == [("fence", "schedule.0.position_m")]


@pytest.mark.parametrize(
    ("autonomy", "command", "not_before", "expected"),
    [
        ("mission", 2, "", True),
        ("mission", 2, ", not_before: 20 s", False),  # it may still wait
        ("mission", 3, "", False),  # the way to a place
        ("mission", 1, "", False),  # the plan
        ("waypoint", 2, "", False),  # the operator's own commands come between
    ],
)
def test_a_cancelled_command_that_is_over_already_is_found(
    autonomy: str, command: int, not_before: str, expected: bool
) -> None:
    text = (
        f"{TWO}autonomy: {autonomy}\nschedule: [{{at: 9 s, do: cancel, command: {command}}}, {{at: 2 s, do: go_to, "
        f"position: [1 m, 1 m], not_before: 20 s}}, {{at: 1 s, do: set_timeout, timeout: 60 s{not_before}}}]\n"
    )
    assert (("schedule", "schedule.0.command") in kinds(text)) == expected


@pytest.mark.parametrize(
    ("more", "prevented"),
    [
        ("operator: {released: 1}\n", True),
        ("operator: {released: 1}\nexpect: {reached: 1}\n", False),
        ("operator: {released: 1}\nschedule: [{at: 3 s, do: release, released: -1}]\n", False),
        ("operator: {released: 1}\nschedule: [{at: 3 s, do: abort}]\n", False),
        (PIT % "8 m, 16 m", True),
        (PIT % "8 m, 11 m", False),  # a policy may walk around it
        ("link: {up: {loss: 1}}\n", True),
        ("link: {up: {rate: 1 kbit/s, windows: [{from: 0 s, to: 10 ms}]}}\n", True),
        ("link: {down: {rate: 1 kbit/s, windows: [{from: 0 s, to: 10 ms}], windows_period: 1 s}}\n", True),
        ("defaults: {timeout: 3 s}\n", False),  # another policy may be faster
    ],
)
def test_a_mission_that_cannot_succeed_is_told_from_one_that_may(more: str, prevented: bool) -> None:
    mission = parse_mission(f"name: n\npolicy: p\n{TWO}{more}".encode(), "m.yaml")
    assert cannot_succeed(mission, check_mission(mission, 2.0)) == prevented


@pytest.mark.parametrize(
    "changes",
    [
        {"operator": {"released": 0}},
        {"onboard": {"geofence": {"keep_out": [{"center_m": [1.0, 0.0], "radius_m": 0.1}]}}},
        {"onboard": {"geofence": {"keep_out": [{"center_m": [1.0, 0.0], "radius_m": 0.1}]}}, "autonomy": "waypoint"},
        {"link": {"down": {"loss": 1.0}}},
        {"link": {"up": {"windows": [{"from_s": 0.0, "to_s": 0.001}], "rate_bps": 1000.0}}},
    ],
)
def test_what_is_said_not_to_succeed_fails_when_it_is_flown(changes: dict[str, Any]) -> None:
    mission = mission_of({"position_m": [1.0, 0.0]}, **changes)
    assert cannot_succeed(mission, check_mission(mission, 2.0))
    result = fly(mission, load_policy(ROOT / "policies" / "ant-waypoint"), lambda _: None)
    assert result.outcome == "failure"


def test_each_kind_of_finding_is_in_the_manual() -> None:
    sources = "".join(path.read_text() for path in (ROOT / "waypointctl/flight/checks").glob("*.py"))
    kinds_there_are = set(re.findall(r'Finding\(\s*"(\w+)"', sources))
    assert set(re.findall(r"^\| `(\w+)` \|", (ROOT / "docs/validate.md").read_text(), re.M)) == kinds_there_are


@pytest.mark.parametrize("path", sorted((ROOT / "missions").glob("*.yaml")), ids=lambda path: path.stem)
def test_of_the_shipped_missions_only_timeouts_that_are_meant_are_found(path: Path) -> None:
    meant = {"optional-stop": 1, "retry-then-skip": 1}.get(path.stem, 0)
    assert [each.kind for each in check_mission(load_mission(path).mission, 2.07)] == ["timeout"] * meant
