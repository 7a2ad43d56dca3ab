from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from waypointctl.evaluation.walking_speed import walking_speed
from waypointctl.flight.fly import fly
from waypointctl.flight.forecast.forecast import Forecast, WalkingSpeed, forecast
from waypointctl.flight.forecast.goals import SETTING_OUT_S
from waypointctl.mission.files import load_mission, parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.policy.bundle import LoadedPolicy, load_policy

ROOT = Path(__file__).parents[3]
NAMES = ("optional-stop", "paper-two-point-moon", "paper-two-point-moon-waypoint", "sample-stops", "ten-second")
BASE = "name: n\npolicy: p\n"
ONE = BASE + "waypoints: [[8, 6]]\n"

# How far a flight may be off its forecast: robots accelerate, overshoot and turn, which no formula of L / v knows.
BAND = 0.08
STEERED_BAND = (0.8, 1.5)  # each short goal begins from standing
JOINT_BAND = (1 - BAND, 1.2)  # actions that are a control step old walk slower: docs/delay.md


@pytest.fixture(scope="module")
def policy() -> LoadedPolicy:
    return load_policy(ROOT / "policies" / "ant-waypoint")


def told(text: str) -> Forecast:
    return forecast(parse_mission(text.encode(), "m.yaml"), WalkingSpeed(2.0, "assumed"))


def kinds(text: str) -> list[tuple[str, tuple[str | int, ...]]]:
    return [(finding.kind, finding.path) for finding in told(text).findings]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("autonomy", ["mission", "waypoint"])
def test_a_flight_commanded_in_another_way_takes_about_as_long_as_was_told(
    name: str, autonomy: str, policy: LoadedPolicy
) -> None:
    mission = load_mission(ROOT / "missions" / f"{name}.yaml").mission.model_copy(update={"autonomy": autonomy})
    flown = fly(mission, policy, lambda _: None)
    found = forecast(mission, walking_speed(ROOT / "policies" / "ant-waypoint"))
    assert flown.outcome == "success"
    assert found.own.time_s == pytest.approx(flown.known_ns / 1e9, rel=BAND)


@pytest.mark.parametrize("path", sorted((ROOT / "missions").glob("*.yaml")), ids=lambda path: path.stem)
def test_each_shipped_mission_takes_about_as_long_as_was_told(path: Path, policy: LoadedPolicy) -> None:
    mission = load_mission(path).mission
    flown = fly(mission, policy, lambda _: None)
    found = forecast(mission, walking_speed(ROOT / "policies" / "ant-waypoint"))
    assert flown.outcome == "success"
    assert found.own.time_s is not None
    ratio = flown.known_ns / 1e9 / found.own.time_s
    if found.not_counted:
        assert ratio > 1 - BAND
    elif mission.autonomy == "heading":
        assert STEERED_BAND[0] < ratio < STEERED_BAND[1]
    elif mission.autonomy == "joint":
        assert JOINT_BAND[0] < ratio < JOINT_BAND[1]
    else:
        assert ratio == pytest.approx(1, abs=BAND)


def test_of_a_good_mission_nothing_is_said() -> None:
    assert told(ONE + "link: {delay: 1 s}\nexpect: {max_time: 10 s}\n").findings == ()


def test_what_is_not_counted_is_said() -> None:
    assert told(ONE).not_counted == ()
    more = "schedule: [{at: 3 s, do: hold}]\nlink: {down: {loss: {p: 0.1, r: 0.5}}}\n"
    assert told(ONE + more).not_counted == ("losses",)
    steered = "autonomy: joint\n" + more.replace("hold", "abort")
    assert told(ONE + steered).not_counted == ("the schedule", "losses")  # a point cannot stand for that robot
    tail = load_mission(ROOT / "missions" / "long-tail.yaml").mission
    assert forecast(tail, WalkingSpeed(2.0, "assumed")).not_counted == ("jitter",)


FENCE = "onboard: {geofence: {keep_out: [{name: pit, center: [4 m, 3 m], radius: 1 m}]}}\n"


@pytest.mark.parametrize(
    ("more", "found"),
    [
        (FENCE, [("fence", ("waypoints", 0))]),
        (FENCE.replace("4 m, 3 m", "8 m, 6 m"), [("fence", ("waypoints", 0))]),
        (FENCE.replace("4 m, 3 m", "0 m, 0 m"), [("fence", ("start",))]),
        (FENCE.replace("4 m, 3 m", "40 m, 3 m"), []),
        (
            FENCE.replace("4 m, 3 m", "40 m, 3 m").replace("}}", "}, home: {position: [40 m, 3 m]}}"),
            [("fence", ("onboard", "home", "position_m"))],
        ),
        ("defaults: {timeout: 4 s}\n", [("timeout", ("waypoints", 0, "timeout_s"))]),
        ("defaults: {timeout: 4 s}\non_failure: {retry: 1}\n", [("timeout", ("waypoints", 0, "timeout_s"))]),
        ("expect: {max_time: 4 s}\n", [("max_time", ("expect", "max_time_s"))]),
        ("onboard: {link_loss: {after: 5 s}}\n", [("heartbeat", ("onboard", "link_loss"))]),
        ("onboard: {link_loss: {after: 5 s}}\noperator: {heartbeat: 1 s}\n", []),
        ("onboard: {link_loss: {after: 5 s}}\noperator: {heartbeat: 5 s}\n", [("heartbeat", ("onboard", "link_loss"))]),
        ("operator: {released: 0}\n", [("release", ("operator", "released"))]),
        ("operator: {released: 1}\n", []),
        ("onboard: {link_loss: {after: 5 s}}\nautonomy: joint\n", []),
        ("operator: {released: 0}\nschedule: [{at: 3 s, do: release, released: -1}]\n", []),
        ("operator: {released: 0}\nautonomy: waypoint\n", [("unused", ("operator", "released"))]),
        ("link: {down: {rate: 1 kbit/s}}\n", [("rate", ("link", "down", "rate_bps"))]),
        ("link: {down: {rate: 10 kbit/s}}\n", []),
        ("link: {delay: 200 ms}\nautonomy: joint\n", [("delay", ("autonomy",))]),
        ("link: {down: {rate: 90 kbit/s}}\nautonomy: joint\n", [("rate", ("link", "down", "rate_bps"))]),
        ("link: {up: {rate: 30 kbit/s}}\nautonomy: joint\n", [("rate", ("link", "up", "rate_bps"))]),
    ],
)
def test_what_may_go_wrong_is_found(more: str, found: list[tuple[str, tuple[str | int, ...]]]) -> None:
    assert kinds(ONE + more) == found


def test_what_is_wrong_with_a_waypoint_is_told_once_for_all_rounds() -> None:
    found = told(
        f"{BASE}waypoints: [[8, 6], [0, 0]]\ndefaults: {{timeout: 4 s}}\non_failure: skip\nrepeat: 9\n"
    ).findings
    assert len({finding.path for finding in found}) == len(found) <= 2


@pytest.mark.parametrize(
    ("waypoints", "found"),
    [
        ("[[0.4, 0.4]]", [0]),
        ("[{position: [0.4 m, 0.4 m], acceptance: radius}]", []),
        ("[[5, 5], [5.9, 5]]", [1]),
        ("[[5, 5], [6.1, 5]]", []),
        ("[[5, 5], {position: [6.1 m, 5 m], tolerance: 70 cm}]", [1]),
    ],
)
def test_waypoints_that_are_one_place_are_found(waypoints: str, found: list[int]) -> None:
    assert kinds(f"{BASE}waypoints: {waypoints}\n") == [("near", ("waypoints", index)) for index in found]


def test_the_speed_is_that_of_the_evaluation_beside_the_policy(tmp_path: Path) -> None:
    shipped = walking_speed(ROOT / "policies" / "ant-waypoint")
    assert shipped.mps == pytest.approx(2.07, abs=0.05)
    assert shipped.source == "mean speed of ant-waypoint in the suite region"
    assert walking_speed(tmp_path / "mine") == WalkingSpeed(2.0, "assumed: no evaluation of mine states its speed")
    kept = (ROOT / "policies" / "ant-waypoint" / "evaluation.json").read_bytes()
    (tmp_path / "evaluation.json").write_bytes(kept)
    (tmp_path / "evaluation-region.json").write_text("{}")
    assert walking_speed(tmp_path).source == "mean speed of ant-waypoint in the suite paper"


def test_a_faster_robot_is_told_to_be_there_sooner() -> None:
    mission: Mission = parse_mission(ONE.encode(), "m.yaml")
    times = [forecast(mission, replace(WalkingSpeed(1.0, "x"), mps=mps)).own.time_s for mps in (1.0, 2.0)]
    way_m = 10 - 0.5 / 0.8  # to where the waypoint counts as reached
    assert times == pytest.approx([SETTING_OUT_S + way_m, SETTING_OUT_S + way_m / 2])
