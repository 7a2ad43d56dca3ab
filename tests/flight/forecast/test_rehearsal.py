from __future__ import annotations

from pathlib import Path

import pytest

from waypointctl.flight.fly import fly
from waypointctl.flight.forecast import effect
from waypointctl.flight.forecast.budget import Budget
from waypointctl.flight.forecast.forecast import Forecast, WalkingSpeed, forecast
from waypointctl.flight.forecast.rehearsal import rehearse
from waypointctl.mission.files import load_mission, parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.units import seconds

ROOT = Path(__file__).parents[3]
SPEED = WalkingSpeed(2.07, "measured")
BAND = 0.1  # a flight turns and accelerates, a point does not

TWO = "name: n\npolicy: p\nlink: {delay: 1.28 s}\nwaypoints: [[5, 0], [5, 5]]\n"
FENCED = (
    "name: n\npolicy: p\nlink: {delay: 1.28 s}\nwaypoints: [[5, 0], [5, 5], [20, 5]]\n"
    "onboard: {geofence: {keep_in: [{corners: [[-1, -1], [10, -1], [10, 10], [-1, 10]]}]}}\n"
)
NEVER_ENDS = "no command follows this hold: the mission never ends"
FAIL = "the mission is expected to fail by this "


@pytest.fixture(scope="module")
def policy() -> LoadedPolicy:
    return load_policy(ROOT / "policies" / "ant-waypoint")


def read(text: str) -> Mission:
    return parse_mission(text.encode(), "m.yaml")


def told(mission: Mission) -> Forecast:
    return forecast(mission, SPEED)


# What fails although nothing is wrong with the file, and what is said of it.
FAILING = [
    (TWO + "schedule: [{at: 2 s, do: hold}]\n", NEVER_ENDS),
    (TWO + "schedule: [{at: 1 s, do: resume}, {at: 2 s, do: hold}]\n", NEVER_ENDS),
    (TWO + "schedule: [{at: 3 s, do: hold}, {at: 2 s, do: resume}]\n", NEVER_ENDS),
    (TWO + "schedule: [{at: 2 s, do: cancel, command: 1}]\n", FAIL + "cancel"),
    (TWO + "schedule: [{at: 2 s, do: skip}]\n", FAIL + "skip"),
    (TWO + "schedule: [{at: 1 s, do: set_timeout, timeout: 1 s}]\n", FAIL + "set_timeout"),
    (TWO + "schedule: [{at: 2 s, do: return_home}]\nexpect: {reached: 1}\n", FAIL + "return_home"),
    (TWO + "onboard: {stuck: {within: 1 m, for: 100 ms}}\n", "1 m in 0.1 s is 10.0 m/s"),
    (TWO + "onboard: {stuck: {within: 50 cm, for: 500 ms}}\n", "0.5 m in 0.5 s: a robot that stands takes 0.4 s"),
    (FENCED, "WP3 is outside keep-in: the robot will reject the whole plan"),
    (FENCED + "autonomy: waypoint\n", "WP3 is outside keep-in: the robot will reject it, and the mission ends there"),
    (FENCED + "autonomy: heading\n", "WP3 is outside keep-in: the robot will reject the first goal outside"),
]


@pytest.mark.parametrize(("text", "said"), FAILING)
def test_what_is_expected_never_to_succeed_fails_when_it_is_flown(text: str, said: str, policy: LoadedPolicy) -> None:
    mission = read(text)
    found = told(mission)
    assert found.own.time_s is None
    assert [each.text for each in found.findings if each.text.startswith(said)]
    result = fly(mission, policy, lambda _: None)
    assert result.outcome == "failure"
    rehearsed = rehearse(mission, SPEED.mps, 20.0)
    assert rehearsed is not None
    assert not rehearsed.good
    assert rehearsed.reached == result.waypoints_reached
    if rehearsed.ends:
        assert rehearsed.time_s == pytest.approx(seconds(result.known_ns), rel=BAND, abs=0.9)


# What a schedule makes longer or shorter, and good all the same.
GOOD = [
    TWO + "schedule: [{at: 1 s, do: hold}, {at: 9 s, do: resume}]\n",
    TWO + "schedule: [{at: 1 s, do: hold}, {at: 9 s, do: return_home}]\nexpect: {reached: 0}\n",
    TWO + "schedule: [{at: 0 s, do: hold, not_before: 3 s}, {at: 20 s, do: resume}]\n",
    TWO + "autonomy: waypoint\nschedule: [{at: 1 s, do: hold}, {at: 9 s, do: resume}]\n",
    TWO + "autonomy: heading\nschedule: [{at: 1 s, do: hold}, {at: 9 s, do: resume}]\n",
    TWO + "schedule: [{at: 2 s, do: skip}]\nexpect: {reached: 1}\n",
    TWO + "operator: {released: 1}\nschedule: [{at: 9 s, do: release, released: -1}]\n",
]


@pytest.mark.parametrize("text", GOOD)
def test_what_a_schedule_adds_is_counted(text: str, policy: LoadedPolicy) -> None:
    mission = read(text)
    found = told(mission)
    assert found.findings == ()
    assert found.not_counted == ()
    result = fly(mission, policy, lambda _: None)
    assert result.outcome == "success", result.reason
    assert found.own.time_s == pytest.approx(seconds(result.known_ns), rel=BAND)


@pytest.mark.parametrize("name", ["hold-and-resume", "released-in-stages"])
def test_the_shipped_schedules_are_counted(name: str, policy: LoadedPolicy) -> None:
    mission = load_mission(ROOT / "missions" / f"{name}.yaml").mission
    result = fly(mission, policy, lambda _: None)
    found = told(mission)
    assert found.findings == ()
    assert found.own.time_s == pytest.approx(seconds(result.known_ns), rel=BAND)


def test_the_first_command_after_which_nothing_helps_is_to_blame() -> None:
    both = "{at: 1 s, do: hold}, {at: 3 s, do: resume}"
    schedule = f"{both}, {{at: 4 s, do: set_tolerance, tolerance: 1 m}}, {{at: 5 s, do: abort}}, {{at: 6 s, do: hold}}"
    findings = told(read(f"{TWO}schedule: [{schedule}]\n")).findings
    assert [each.path for each in findings if each.kind == "schedule"] == [("schedule", 3, "do")]


def test_a_mission_that_fails_without_its_schedule_too_is_not_blamed_on_it() -> None:
    text = TWO + "defaults: {timeout: 1 s}\nschedule: [{at: 9 s, do: skip}]\n"
    found = told(read(text))
    assert found.not_counted == ()
    assert {each.kind for each in found.findings} == {"timeout"}
    assert found.own.fails.startswith("timeout at about ")


def test_a_pilot_cannot_be_rehearsed() -> None:
    assert rehearse(read(TWO + "autonomy: joint\n"), 2.0, 10.0) is None


@pytest.mark.parametrize("then", ["", ", {at: 2 s, do: go_to, position: [1 m, 1 m]}", ", {at: 2 s, do: resume}"])
def test_a_pilot_who_holds_goes_on_only_when_it_is_told_to(then: str, policy: LoadedPolicy) -> None:
    near = TWO.replace("1.28 s", "0 s") + "autonomy: joint\nexpect: {max_time: 30 s}\n"
    mission = read(f"{near}schedule: [{{at: 1 s, do: hold}}{then}]\n")
    texts = [each.text for each in told(mission).findings if each.kind == "schedule"]
    assert (texts == [NEVER_ENDS]) == ("resume" not in then)
    assert (fly(mission, policy, lambda _: None).outcome == "success") == ("resume" in then)


def test_long_ways_take_no_more_steps() -> None:
    far = "name: n\npolicy: p\ndefaults: {timeout: 1 d}\nwaypoints: [[9000, 0], [0, 9000]]\n"
    rehearsed = rehearse(read(far), 2.0, 10_864.0)
    assert rehearsed is not None
    assert rehearsed.good
    assert rehearsed.time_s == pytest.approx((9_000 + 9_000 * 2**0.5) / 2.0, rel=0.001)


def test_what_takes_too_many_steps_is_not_known_and_not_counted() -> None:
    far = TWO.replace("{delay: 1.28 s}", "{delay: 1 h}") + (
        "defaults: {timeout: 1 d}\nautonomy: heading\noperator: {steering: continuous, update_rate: 10 Hz}\n"
        "schedule: [{at: 1 min, do: hold}, {at: 5 min, do: resume}]\n"
    )
    budget = Budget(50)
    assert rehearse(read(far), 2.0, 1e5, budget) is None
    assert budget.left == -1
    found = forecast(read(far), SPEED)
    assert found.own.time_s is not None
    assert "the schedule" in found.not_counted


def test_the_missions_own_autonomy_is_rehearsed_first(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def note(mission: Mission, *_: object) -> None:
        asked.append(mission.autonomy)

    monkeypatch.setattr(effect, "rehearse", note)
    schedule = "schedule: [{at: 1 s, do: hold}, {at: 2 s, do: resume}]\n"
    forecast(read(TWO + "autonomy: heading\n" + schedule), SPEED)
    assert asked == 2 * ["heading"] + 2 * ["mission"] + 2 * ["waypoint"]  # joint is a fall


# What goes on after the operator knows how the mission has gone.
GIVEN_UP = (
    "name: n\npolicy: p\nseed: 4\nlink: {delay: 1.5 s}\n"
    "waypoints: [[6, 0], {position: [30 m, 0 m], timeout: 4 s}]\nexpect: {reached: 1}\n"
)
ROCK = "onboard: {geofence: {keep_out: [{center: [12 m, 0 m], radius: 1 m}], do: return_home}}\n"
GOES_ON = {
    "home by the rule of a leg": GIVEN_UP + "on_failure: return_home\n",
    "home by the rule of a leg, waypoint by waypoint": GIVEN_UP + "on_failure: return_home\nautonomy: waypoint\n",
    "home from the fence": GIVEN_UP.replace("4 s", "20 s") + ROCK,
    "home when the link is lost after the end": (
        "name: n\npolicy: p\nseed: 4\nlink: {delay: 1.5 s}\nwaypoints: [[6, 0], [6, 6]]\nautonomy: waypoint\n"
        "onboard: {link_loss: {after: 4 s, do: return_home}}\n"
    ),
    "a home much farther than the way": (
        GIVEN_UP + "on_failure: return_home\nonboard: {home: {position: [-40 m, 0 m], timeout: 100 s}}\n"
    ),
}


@pytest.mark.parametrize("text", GOES_ON.values(), ids=GOES_ON)
def test_what_goes_on_after_the_operator_knows_the_end_is_in_the_duration(text: str, policy: LoadedPolicy) -> None:
    mission = read(text)
    found = told(mission)
    result = fly(mission, policy, lambda _: None)
    assert result.outcome == "success", result.reason
    assert result.sim_time_ns > result.known_ns
    assert found.own.time_s == pytest.approx(seconds(result.sim_time_ns), rel=BAND)
    limit_s = seconds(result.known_ns + result.sim_time_ns) / 2
    limited = mission.model_copy(update={"expect": mission.expect.model_copy(update={"max_time_s": limit_s})})
    late = told(limited)
    assert not late.own.succeeds
    assert "max_time" in {each.kind for each in late.findings}
    assert fly(limited, policy, lambda _: None).outcome == "failure"


def test_a_steered_leg_that_is_given_up_lasts_as_long_as_in_flight(policy: LoadedPolicy) -> None:
    mission = read(GIVEN_UP + "autonomy: heading\n")
    result = fly(mission, policy, lambda _: None)
    assert told(mission).own.time_s == pytest.approx(seconds(result.sim_time_ns), rel=2 * BAND)


def test_a_long_way_home_is_rehearsed_to_its_end() -> None:
    home = "onboard: {home: {position: [-900 m, 0 m], timeout: 900 s}}\n"
    found = told(read(GIVEN_UP + "on_failure: return_home\n" + home))
    assert found.own.time_s is not None
    assert found.own.time_s > 900 / SPEED.mps
