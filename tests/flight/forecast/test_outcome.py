"""What a warning says is in the prediction: how a mission is expected to end agrees with what is found, and flown."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from waypointctl.evaluation.walking_speed import walking_speed
from waypointctl.flight.fly import fly
from waypointctl.flight.forecast.finding import NOT_COMPLETED
from waypointctl.flight.forecast.forecast import Forecast, WalkingSpeed, forecast
from waypointctl.mission.files import load_mission, parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.policy.bundle import load_policy

ROOT = Path(__file__).parents[3]
POLICY = ROOT / "policies" / "ant-waypoint"
HEAD = "name: n\npolicy: p\nseed: 1\n"


def read(text: str) -> Mission:
    return parse_mission((HEAD + text).encode(), "m.yaml")


def fence(*areas: str, do: str = "hold", more: str = "") -> str:
    return f"onboard: {{geofence: {{keep_out: [{', '.join(areas)}], do: {do}}}{more}}}\n"


ROCK = "{name: rock, center: [5 m, 0 m], radius: 1 m}"
AHEAD = "waypoints: [[10, 0]]\n"
ROUND = "waypoints: [[0, 8], [10, 8], [10, 0]]\n"
WALL = "{name: wall, corners: [[4, 20], [4.1, 20], [4.1, -20], [4, -20]]}"
KEEP_IN = "onboard: {geofence: {keep_in: [{corners: [[-1, -1], [12, -1], [12, 12], [9, 12], [9, 3], [-1, 3]]}]}}\n"
FAILS = {
    "the first leg": (AHEAD + fence(ROCK), "the leg to WP1 crosses keep-out rock: will not be completed"),
    "a later leg": (
        "waypoints: [[0, 8], [10, 8], [10, 0], [0, 0]]\n" + fence(ROCK),
        "the leg to WP4 crosses keep-out rock: will not be completed",
    ),
    "a leg between two rounds": (
        ROUND + "repeat: 2\n" + fence("{name: pit, center: [5 m, 4 m], radius: 1 m}"),
        "the leg to WP1 (2) crosses keep-out pit: will not be completed",
    ),
    "an area narrower than a step": (
        "waypoints: [[400, 0]]\ndefaults: {timeout: 10 min}\n" + fence(WALL),
        "the leg to WP1 crosses keep-out wall: will not be completed",
    ),
    "a leg out of keep-in and back": (
        "waypoints: [[10.5, 11]]\n" + KEEP_IN,
        "the leg to WP1 leaves keep-in: will not be completed",
    ),
    "a leg after one that is skipped": (
        "waypoints: [{position: [20 m, 0 m], timeout: 4 s}, [0, 10]]\non_failure: skip\nexpect: {reached: 1}\n"
        + fence("{name: bog, center: [4 m, 5 m], radius: 1 m}"),
        "the leg to WP2 crosses keep-out bog where it begins at",
    ),
    "an abort at the fence": (
        AHEAD + fence(ROCK, do="abort"),
        "the leg to WP1 crosses keep-out rock: will not be completed",
    ),
    "home from the fence": (
        AHEAD + fence(ROCK, do="return_home"),
        "the leg to WP1 crosses keep-out rock: will not be completed",
    ),
    "steered": (
        AHEAD + "autonomy: heading\n" + fence(ROCK),
        "the leg to WP1 crosses keep-out rock: will not be completed",
    ),
    "action by action": (
        AHEAD + "autonomy: joint\nexpect: {max_time: 30 s}\n" + fence(ROCK),
        "the leg to WP1 crosses keep-out rock: will not be completed",
    ),
    "the start": (AHEAD + fence("{name: pit, center: [0 m, 0 m], radius: 1 m}"), "the start is inside keep-out pit"),
    "too little time": (AHEAD + "defaults: {timeout: 2 s}\n", f": {NOT_COMPLETED}"),
    "too little time for all": (AHEAD + "expect: {max_time: 2 s}\n", "2 s is shorter than the expected duration"),
    "a tolerance that no robot meets": (AHEAD + "defaults: {tolerance: 0.1 mm}\n", f": {NOT_COMPLETED}"),
    "a link that seems lost": (
        AHEAD + "onboard: {link_loss: {after: 2 s, do: hold}}\n",
        "the link counts as lost 2 s after any command",
    ),
    "heartbeats too far apart, and home": (
        AHEAD + "operator: {heartbeat: 3 s}\nonboard: {link_loss: {after: 2 s, do: return_home}}\n",
        "heartbeats are 3 s apart",
    ),
    "a queue without room for the first command": (
        AHEAD + "link: {up: {windows: [{from: 5 s, to: 60 s}], queue: 16 B}}\ncommands: {retries: 0}\n",
        "the queue has room for 16 bytes",
    ),
    "a time that setting out makes too short": (
        "waypoints: [[6, 0]]\nautonomy: waypoint\non_failure: skip\ndefaults: {timeout: 2.8 s}\n",
        "the mission is expected to fail: not all reached at about",
    ),
    "actions that wait": (
        AHEAD + "autonomy: joint\nlink: {up: {rate: 20 kbit/s}}\n",
        "they wait, and come later and later",
    ),
}
SUCCEEDS = {
    "a skipped leg that need not be reached": (
        "waypoints: [[20, 0], [5, 5]]\ndefaults: {timeout: 4 s}\non_failure: skip\nexpect: {reached: 1}\n"
    ),
    "a straight line across a corner that the robot cuts": (
        "waypoints: [{position: [10 m, 0 m], tolerance: 2 m}, [10, 10]]\n"
        + fence("{name: post, center: [10.3 m, 0 m], radius: 20 cm}")
    ),
    "an area beside the way": AHEAD + fence("{name: rock, center: [5 m, 3 m], radius: 1 m}"),
    "heartbeats in time": AHEAD + "operator: {heartbeat: 1 s}\nonboard: {link_loss: {after: 2 s, do: hold}}\n",
}


def told(text: str) -> Forecast:
    return forecast(read(text), walking_speed(POLICY))


@pytest.mark.parametrize(("text", "said"), FAILS.values(), ids=FAILS)
def test_what_is_found_to_fail_is_predicted_and_flown_to_fail(text: str, said: str) -> None:
    found = told(text)
    assert not found.own.succeeds
    assert any(said in finding.text for finding in found.findings), found.findings
    limit = read(text).expect.max_time_s or 120.0
    mission = read(text)
    limited = mission.model_copy(update={"expect": mission.expect.model_copy(update={"max_time_s": limit})})
    assert fly(limited, load_policy(POLICY), lambda _: None).outcome == "failure"


@pytest.mark.parametrize("text", SUCCEEDS.values(), ids=SUCCEEDS)
def test_what_is_predicted_to_succeed_does(text: str) -> None:
    found = told(text)
    assert found.own.succeeds
    assert not any(NOT_COMPLETED in finding.text for finding in found.findings)
    assert fly(read(text), load_policy(POLICY), lambda _: None).outcome == "success"


@pytest.mark.parametrize("path", sorted((ROOT / "missions").glob("*.yaml")), ids=lambda path: path.stem)
def test_each_shipped_mission_is_predicted_to_succeed(path: Path) -> None:
    found = forecast(load_mission(path).mission, walking_speed(POLICY))
    assert found.own.succeeds, found.own.fails


def test_a_way_home_through_the_fence_is_told() -> None:
    home = "waypoints: [[0, 8], [10, 8]]\non_failure: return_home\n" + fence("{center: [5 m, 4 m], radius: 1 m}")
    (finding,) = told(home).findings
    assert finding.text == "the straight way home from WP2 crosses keep-out 1: it will not be completed"
    scheduled = home.replace("on_failure: return_home\n", "schedule: [{at: 1 s, do: return_home}]\n")
    assert not any("way home" in finding.text for finding in told(scheduled).findings), "not from everywhere"


def test_losses_are_in_the_prediction_as_a_probability() -> None:
    assert told(AHEAD).chance == 1.0
    lossy = told(AHEAD + "autonomy: waypoint\nlink: {loss: 60 %}\ncommands: {retries: 0}\n")
    assert lossy.own.succeeds
    assert lossy.chance == pytest.approx(0.4), "one command, which has to arrive"
    beats = (
        "operator: {heartbeat: 500 ms}\nonboard: {link_loss: {after: 1 s, do: return_home}}\nlink: {up: {loss: 50 %}}\n"
    )
    assert told(AHEAD + beats).chance < 0.5


numbers = st.integers(-12, 12)


@settings(max_examples=20, deadline=None)
@given(
    st.lists(st.tuples(numbers, numbers), min_size=1, max_size=4),
    st.lists(st.tuples(numbers, numbers), max_size=2),
    st.sampled_from(["hold", "abort", "return_home"]),
    st.sampled_from(["abort", "skip", "hold", "return_home"]),
    st.sampled_from([2, 30]),
    st.sampled_from(["mission", "waypoint", "heading", "joint"]),
    st.sampled_from(["", "{after: 3 s, do: hold}", "{after: 3 s, do: return_home}"]),
    st.sampled_from([0, "all"]),
)
def test_prediction_and_warnings_agree(
    places: list[tuple[int, int]],
    rocks: list[tuple[int, int]],
    do: str,
    then: str,
    timeout_s: int,
    autonomy: str,
    loss: str,
    reached: int | str,
) -> None:
    areas = [f"{{center: [{x} m, {y} m], radius: 1.5 m}}" for x, y in rocks]
    found = forecast(
        read(
            f"waypoints: {[list(place) for place in places]}\nautonomy: {autonomy}\non_failure: {then}\n"
            f"defaults: {{timeout: {timeout_s} s}}\nexpect: {{reached: {reached}}}\n"
            + fence(*areas, do=do, more=f", link_loss: {loss}" if loss else "")
        ),
        WalkingSpeed(2.0, "assumed"),
    )
    concluded = [finding for finding in found.findings if NOT_COMPLETED in finding.text]
    if found.own.succeeds:
        assert not concluded
        assert found.own.time_s is not None
    else:
        assert any(finding.kind not in ("near", "unused") for finding in found.findings)
        assert all(finding in concluded for finding in found.findings if finding.consequence)
