from __future__ import annotations

import math

import pytest
from pydantic import ValidationError

from waypointctl.errors import MissionError
from waypointctl.mission.files import parse_mission
from waypointctl.mission.link import Link, LinkDirection
from waypointctl.mission.mission import Leg, Mission, Waypoint

HEAD = "name: n\npolicy: p\n"
MINIMAL = HEAD + "waypoints: [[7, 12]]\n"


def parse(text: str) -> Mission:
    return parse_mission(text.encode(), "m.yaml")


def refusal(text: str) -> str:
    with pytest.raises(MissionError) as caught:
        parse(text)
    return str(caught.value)


def test_what_is_left_out_has_a_default() -> None:
    mission = parse(MINIMAL)
    assert mission == Mission(name="n", policy="p", waypoints=(Waypoint(position_m=(7, 12)),))
    assert (mission.seed, mission.robot, mission.autonomy, mission.failure_rule.then) == (0, "ant", "mission", "abort")
    assert (mission.start.position_m, mission.start.heading_deg) == ((0, 0), 0)
    assert mission.link == Link(up=LinkDirection(delay_s=0, jitter_s=0), down=LinkDirection(delay_s=0, jitter_s=0))
    assert (mission.telemetry.rate_hz, mission.expect.reached, mission.expect.max_time_s) == (5, "all", None)


def test_legs_take_from_the_defaults_what_the_waypoints_leave_open() -> None:
    mission = parse(
        HEAD
        + """
defaults: {acceptance: radius, tolerance: 25 cm, timeout: 1 min, hold: 500 ms}
waypoints:
  - [7, 12]
  - {name: rock, position_m: [-1, 2.5], acceptance: box, tolerance_m: 1, timeout_s: 5, hold_s: 0}
  - {position: [1 km, -20 cm], hold: 2 s}
  - [1 m, 2 mm]
"""
    )
    assert mission.legs() == (
        Leg(0, "WP1", 7.0, 12.0, "radius", 0.25, 60.0, 0.5, at=0),
        Leg(1, "rock", -1.0, 2.5, "box", 1.0, 5.0, 0.0, at=1),
        Leg(2, "WP3", 1000.0, -0.2, "radius", 0.25, 60.0, 2.0, at=2),
        Leg(3, "WP4", 1.0, 0.002, "radius", 0.25, 60.0, 0.5, at=3),
    )


def test_the_path_begins_at_the_start() -> None:
    mission = parse(HEAD + "start: {position_m: [3, 0]}\nwaypoints: [[3, 4], [0, 0]]")
    assert mission.path_length_m() == 4 + 5


@pytest.mark.parametrize(
    ("text", "up", "down"),
    [
        (
            "link: {delay: 1.28 s, jitter: 50 ms}",
            LinkDirection(delay_s=1.28, jitter_s=0.05),
            LinkDirection(delay_s=1.28, jitter_s=0.05),
        ),
        ("link: {delay_s: 2}", LinkDirection(delay_s=2), LinkDirection(delay_s=2)),
        ("link: {up: {delay: 3 min}}", LinkDirection(delay_s=180), LinkDirection()),
        (
            "link: {up: {delay_s: 1}, down: {delay: 2 s, jitter: 2 s}}",
            LinkDirection(delay_s=1),
            LinkDirection(delay_s=2, jitter_s=2),
        ),
    ],
)
def test_a_link_is_written_for_both_ways_or_for_each(text: str, up: LinkDirection, down: LinkDirection) -> None:
    assert parse(MINIMAL + text).link == Link(up=up, down=down)


def test_a_mission_cannot_be_changed() -> None:
    mission = parse(MINIMAL)
    with pytest.raises(ValidationError, match="frozen"):
        mission.seed = 3  # type: ignore[misc]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (HEAD, "1:1: required key 'waypoints' is missing"),
        (HEAD + "waypoints: []", "3:12: waypoints: has 0 entries; at least 1 are needed"),
        (HEAD + "waypoints:", "3:11: waypoints: null is not a list"),
        (HEAD + "waypoints: {a: [1, 2]}", "3:12: waypoints: a mapping is not a list"),
        (HEAD + "waypoints: [[1]]", "3:13: waypoints[0][1]: is missing"),
        (HEAD + "waypoints: [[1, 2, 3]]", "3:13: waypoints[0]: at most 2 entries are allowed; found 3"),
        (HEAD + "waypoints: [7]", "3:13: waypoints[0]: expected a mapping (key: value), found 7"),
        (HEAD + "waypoints: [[.nan, 1]]", "3:14: waypoints[0][0]: nan is not a finite number"),
        (HEAD + "waypoints: [[1, -.inf]]", "3:17: waypoints[0][1]: -inf is not a finite number"),
        (HEAD + "waypoints: [[7 m, 12]]", "3:19: waypoints[0][1]: 12 has no unit; write 'position: [7 m, 12 m]'"),
        (
            HEAD + "waypoints: [{position_m: [7 m, 12]}]",
            "3:27: waypoints[0].position_m[0]: '7 m' is not a number; "
            "numbers in m go under 'position_m', numbers with a unit under 'position'",
        ),
        (HEAD + "waypoints: [[1, 10001]]", "3:17: waypoints[0][1]: must be at most 10,000 m; got 10001 m"),
        (
            HEAD + "waypoints: [{}]",
            "3:13: waypoints[0]: required key 'position' is missing; write 'position: ...' with a unit, or 'position_m: ...' in m",  # noqa: E501
        ),
        (
            HEAD + "waypoints:\n- position_m: [1, 2]\n  tolerance_m: -0.5",
            "5:16: waypoints[0].tolerance_m: must be more than 0 m; got -0.5 m",
        ),
        (
            HEAD + "waypoints: [{position_m: [1, 2], name: A}, {position_m: [3, 4], name: A}]",
            "3:71: waypoints[1].name: 'A' is the name of waypoints[0] already",
        ),
        (
            HEAD + "waypoints: [{position_m: [1, 2], name: WP2}, [3, 4]]",
            "3:46: waypoints[1]: 'WP2' is the name of waypoints[0] already",
        ),
        (
            HEAD + 'waypoints: [{position_m: [1, 2], name: "a\\nb"}]',
            "3:40: waypoints[0].name: 'a\\nb' is not one line of text without control characters",
        ),
        (MINIMAL + "expect: {reached: 2}", "4:19: expect.reached: 2 is more than the 1 waypoints of the mission"),
        (
            MINIMAL + "expect: {reached: most}",
            "4:19: expect.reached: 'most' is neither 'all' nor a whole number",
        ),
        (MINIMAL + "expect: {max_time: 0 s}", "4:20: expect.max_time: must be more than 0 s; got 0 s"),
        (MINIMAL + "seed: -1", "4:7: seed: expected a whole number from 0 to 9223372036854775807; got -1"),
        (MINIMAL + "seed: 1.5", "4:7: seed: 1.5 is not a whole number"),
        (MINIMAL + "seed: true", "4:7: seed: true is not a whole number"),
        (MINIMAL + "seed: '3'", "4:7: seed: '3' is not a whole number"),
        (MINIMAL + f"seed: {2**63}", f"4:7: seed: expected a whole number from 0 to 9223372036854775807; got {2**63}"),
        (
            MINIMAL + "autonomy: alone",
            "4:11: autonomy: expected one of 'mission', 'waypoint', 'short_range_goal' or 'joint'; got 'alone'",
        ),
        (
            MINIMAL + "autonomy: way point",
            "4:11: autonomy: expected one of 'mission', 'waypoint', 'short_range_goal' or 'joint'; got 'way point'; "
            "did you mean 'waypoint'?",
        ),
        (
            MINIMAL + "on_failure: retry",
            "4:13: on_failure: expected one of 'abort', 'skip', 'hold' or 'return_home'; got 'retry'",
        ),
        (
            MINIMAL + "link: 1.28 s",
            "4:7: link: expected a mapping (key: value), found '1.28 s'; write 'link: {delay: 1.28 s}' for a one-way delay",  # noqa: E501
        ),
        (
            MINIMAL + "link: Moon",
            "4:7: link: expected a mapping (key: value), found 'Moon'; write 'link: {preset: moon}'",
        ),
        (
            MINIMAL + "link: mars",
            "4:7: link: expected a mapping (key: value), found 'mars'; write 'link: {preset: mars-near}' "
            "or 'link: {preset: mars-far}'",
        ),
        (
            MINIMAL + "link: saturn",
            "4:7: link: expected a mapping (key: value), found 'saturn'; "
            "for a preset write 'link: {preset: moon|moon-relay|mars-near|mars-far|iss|lan}'",
        ),
        (MINIMAL + "link: {delay: -1 s}", "4:15: link.delay: must be at least 0 s; got -1 s"),
        (MINIMAL + "link: {delay: 11 d}", "4:15: link.delay: must be at most 864,000 s; got 11 d"),
        (
            MINIMAL + "link: {delay: 20}",
            "4:15: link.delay: 20 has no unit; write 'delay: 20 s' or 'delay_s: 20'",
        ),
        (MINIMAL + "link: {delay: 1 s, jitter: 2 s}", "4:28: link.jitter: 2 s is more than the delay of 1 s"),
        (MINIMAL + "link: {up: {jitter: 1 ms}}", "4:21: link.up.jitter: 0.001 s is more than the delay of 0 s"),
        (
            MINIMAL + "link: {delay: 1 s, up: {delay: 2 s}}",
            "4:7: link: 'delay' is for up and down, and 'up' is there too: keep one",
        ),
        (
            MINIMAL + "link: {dealy: 1 s}",
            "4:8: link.dealy: unknown key; did you mean 'delay_s' (a number in s) "
            "or 'delay' (with its unit: ns, us, ms, s, min, h, d)?",
        ),
        (
            MINIMAL + "operator: {released: 2}",
            "4:22: operator.released: 2 is more than the 1 waypoint of the plan; write -1 to release them all",
        ),
        (MINIMAL + "telemetry: {rate: 51 Hz}", "4:19: telemetry.rate: must be at most 50 Hz; got 51 Hz"),
        (MINIMAL + "telemetry: {rate_hz: 0}", "4:22: telemetry.rate_hz: must be at least 0.001 Hz; got 0 Hz"),
        (MINIMAL + "start: {heading: 400 deg}", "4:18: start.heading: must be at most 360 deg; got 400 deg"),
        (MINIMAL + "defaults: {timeout: 2 d}", "4:21: defaults.timeout: must be at most 86,400 s; got 2 d"),
        (MINIMAL + "waypoint: []", "4:1: waypoint: unknown key; did you mean 'waypoints'?"),
        (MINIMAL + "name: m", "4:1: name: duplicate key, first in line 1"),
        (
            MINIMAL.replace("name: n", "name: ../n"),
            "1:7: name: '../n' is not a name of letters, digits, '.', '_', '-' and spaces between them",
        ),
        (MINIMAL.replace("policy: p", "policy: ''"), "2:9: policy: '' is not text of at least 1 characters"),
        ("[]", "1:1: expected a mapping (key: value), found a list"),
        ("walk to the rock", "1:1: expected a mapping (key: value), found 'walk to the rock'"),
        ("", "1:1: is empty"),
    ],
)
def test_a_wrong_mission_says_what_where_and_what_is_allowed(text: str, problem: str) -> None:
    assert refusal(text) == f"m.yaml:{problem}"


def test_problems_in_one_waypoint_do_not_hide_each_other() -> None:
    text = HEAD + "waypoints:\n  - {position: [1 m, 2], timeout: 20, tolerance: 5 in, hodl: 1 s}\nexpect: {reach: 3}\n"
    assert refusal(text).splitlines() == [
        "m.yaml: 5 problems",
        "m.yaml:4:22: waypoints[0].position[1]: 2 has no unit; write 'position: [1 m, 2 m]'",
        "m.yaml:4:35: waypoints[0].timeout: 20 has no unit; write 'timeout: 20 s' or 'timeout_s: 20'",
        "m.yaml:4:50: waypoints[0].tolerance: '5 in' has the unit 'in'; allowed are mm, cm, m, km",
        "m.yaml:4:56: waypoints[0].hodl: unknown key; did you mean 'hold_s' (a number in s) "
        "or 'hold' (with its unit: ns, us, ms, s, min, h, d)?",
        "m.yaml:5:10: expect.reach: unknown key; did you mean 'reached'?",
    ]


def test_python_takes_numbers_alone() -> None:
    with pytest.raises(ValidationError):
        Waypoint(position_m=(1, math.nan))
    with pytest.raises(ValidationError):
        Waypoint.model_validate({"position_m": ("1", 2)})


@pytest.mark.parametrize("version", ["1", "3", "'2'", "2.0", "true"])
def test_another_version_of_the_keys_is_refused(version: str) -> None:
    with pytest.raises(MissionError, match=r"m\.yaml:4:17: schema_version: version .* is not supported; supported: 2$"):
        parse(MINIMAL + f"schema_version: {version}")
    assert parse(MINIMAL + "schema_version: 2") == parse(MINIMAL)


@pytest.mark.parametrize(
    ("text", "new"),
    [
        ("link: {windows_every: 4 s}", "windows_period"),
        ("link: {up: {windows_every_s: 4}}", "windows_period_s"),
        ("link: {contact_plan: {file: a, from_node: 1, to_node: 2, back: true}}", "reverse"),
        ("operator: {carrot: 1 m}", "lookahead"),
        ("onboard: {slip: 1 m}", "stopped_tolerance"),
    ],
)
def test_a_key_of_an_earlier_version_is_refused_with_its_new_name(text: str, new: str) -> None:
    with pytest.raises(MissionError, match=f"unknown key; did you mean .*'{new}'"):
        parse(MINIMAL + text)
