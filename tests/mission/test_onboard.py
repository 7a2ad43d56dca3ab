"""What a mission loads into the robot, as it is written and as it is refused."""

from __future__ import annotations

from functools import cache
from typing import Any

import fastjsonschema
import pytest

from waypointctl.errors import MissionError
from waypointctl.mission.files import mission_schema, parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.mission.onboard import Onboard, OnFailure
from waypointctl.mission.yaml_tree import read_tree

BASE = "name: n\npolicy: p\nwaypoints: [[1, 2]]\n"
CIRCLE = "{center: [3 m, 3 m], radius: 50 cm}"
TRIANGLE = "{corners: [[0, 0], [10 m, 0 m], {position_m: [5, 5]}]}"


def parse(text: str) -> Mission:
    return parse_mission((BASE + text).encode(), "m.yaml")


def test_a_robot_without_rules_gives_up_and_no_more() -> None:
    mission = parse("")
    assert mission.onboard == Onboard()
    assert mission.failure_rule == OnFailure(retry=0, then="abort")


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("on_failure: skip", OnFailure(then="skip")),
        ("on_failure: {retry: 2}", OnFailure(retry=2)),
        ("on_failure: {retry: 1, then: return_home}", OnFailure(retry=1, then="return_home")),
        ("onboard: {on_failure: hold}", OnFailure(then="hold")),
        ("onboard: {on_failure: {then: hold}}", OnFailure(then="hold")),
    ],
)
def test_what_follows_a_failure_is_written_in_either_place(text: str, rule: OnFailure) -> None:
    assert parse(text).failure_rule == rule


def test_a_waypoint_is_observed_if_it_or_the_defaults_say_so() -> None:
    mission = parse_mission(
        b"name: n\npolicy: p\ndefaults: {observe: true}\nwaypoints: [[1, 2], {position_m: [3, 4], observe: false}]\n",
        "m.yaml",
    )
    assert [leg.observe for leg in mission.legs()] == [True, False]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("on_failure: 3", "4:13: on_failure: expected a mapping (key: value), found 3"),
        ("on_failure: {retry: -1}", "4:21: on_failure.retry: expected a whole number from 0 to 1000; got -1"),
        (
            "on_failure: skip\nonboard: {on_failure: hold}",
            "5:10: onboard: 'on_failure' is also given at the top of the mission: keep one",
        ),
        ("onboard: {stopped_tolerance: -1 m}", "4:30: onboard.stopped_tolerance: must be at least 0 m; got -1 m"),
        ("onboard: {stuck: {for: 0 s}}", "4:24: onboard.stuck.for: must be more than 0 s; got 0 s"),
        (
            "onboard: {link_loss: {do: hold}}",
            "4:22: onboard.link_loss: required key 'after' is missing; write 'after: ...' with a unit, or 'after_s: ...' in s",  # noqa: E501
        ),
        (
            "onboard: {geofence: {keep_in: [{corners: [[0, 0], [1, 1]]}]}}",
            "4:42: onboard.geofence.keep_in[0].corners: has 2 entries; at least 3 are needed",
        ),
        (
            "onboard: {geofence: {keep_out: [{corners: [[0, 0], [1, 1], [2, 2]]}]}}",
            "4:33: onboard.geofence.keep_out[0]: has all its corners on one line: a polygon needs room inside",
        ),
        (
            "onboard: {geofence: {keep_out: [{center_m: [0, 1]}]}}",
            "4:33: onboard.geofence.keep_out[0]: is neither a circle (center and radius) nor a polygon (corners): "
            "give one of them",
        ),
        (
            "onboard: {geofence: {keep_out: [{center_m: [0, 1], radius_m: 1, corners: [[0, 0], [1, 0], [0, 1]]}]}}",
            "4:33: onboard.geofence.keep_out[0]: is neither a circle (center and radius) nor a polygon (corners): "
            "give one of them",
        ),
    ],
)
def test_what_is_wrong_is_said_with_its_place(text: str, problem: str) -> None:
    with pytest.raises(MissionError) as caught:
        parse(text)
    assert str(caught.value) == f"m.yaml:{problem}"


@cache
def compiled_schema() -> Any:
    return fastjsonschema.compile(mission_schema())


@pytest.mark.parametrize(
    ("text", "fits"),
    [
        ("on_failure: return_home", True),
        ("on_failure: {retry: 2, then: skip}", True),
        ("on_failure: dance", False),
        (f"onboard: {{geofence: {{keep_in: [{TRIANGLE}, {CIRCLE}], do: abort}}}}", True),
        ("onboard: {geofence: {keep_in: [{corners: [[0, 0]]}]}}", False),
        ("onboard: {stuck: {within: 10 cm, for_s: 5}, stopped_tolerance_m: 1, link_loss: {after: 2 min}}", True),
        ("onboard: {link_loss: {}}", False),
    ],
)
def test_the_schema_reads_what_the_reader_reads(text: str, fits: bool) -> None:
    check = compiled_schema()
    data = read_tree((BASE + text).encode()).data
    if fits:
        check(data)
        parse(text)
    else:
        with pytest.raises(fastjsonschema.JsonSchemaException):
            check(data)
        with pytest.raises(MissionError):
            parse(text)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("start: {position_m: [1, 2], position: [1 m, 2 m]}", "start.position_m: is given as 'position' and as"),
        (
            "onboard: {geofence: {keep_out: [{center: [1 m, 2 m], center_m: [1, 2], radius: 1 m}]}}",
            "keep_out[0].center_m: is given as 'center' and as 'center_m': keep one",
        ),
    ],
)
def test_a_list_of_quantities_is_not_given_twice(text: str, problem: str) -> None:
    with pytest.raises(MissionError) as caught:
        parse(text)
    assert problem in str(caught.value)
