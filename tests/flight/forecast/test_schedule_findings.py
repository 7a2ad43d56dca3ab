from __future__ import annotations

import pytest

from tests.flight.flying import UNDER_FOOT, flown, mission_of, only
from waypointctl.flight.forecast.budget import Budget
from waypointctl.flight.forecast.duration import expected
from waypointctl.flight.forecast.effect import effect_of
from waypointctl.flight.forecast.finding import Finding
from waypointctl.flight.forecast.schedule import schedule_findings
from waypointctl.flight.forecast.traffic import traffic_of
from waypointctl.log.messages import FINAL_STAGES, Action, CommandStage, Stage, State
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Mission

BASE = "name: n\npolicy: p\nwaypoints: [[8, 6], [8, 16]]\n"
FENCE = "onboard: {geofence: {keep_in: [{center: [5 m, 5 m], radius: 15 m}]}}\n"
LATE = "link: {delay: 2 s}\nexpect: {max_time: 30 s}\n"
CLOSED = "link: {up: {windows: [{from: 0 s, to: 9 s}]}}\n"


def of(mission: Mission) -> list[Finding]:
    traffic = traffic_of(mission)
    effect = effect_of(mission, 2.0, expected(mission, 2.0, traffic, mission.autonomy), Budget())
    return list(schedule_findings(mission, traffic, effect))


def found(more: str, schedule: str) -> list[tuple[str, tuple[str | int, ...], str]]:
    mission = parse_mission(f"{BASE}{more}schedule: [{schedule}]\n".encode(), "m.yaml")
    findings = of(mission)
    return [(each.kind, each.path, each.text) for each in findings]


@pytest.mark.parametrize(
    ("more", "command", "field", "text"),
    [
        (LATE, "at: 31 s, do: hold", "at_s", "hold is never sent: the flight ends at 30 s, its expect.max_time"),
        (LATE, "at: 29 s, do: skip", "at_s", "skip arrives at about 31.00 s, and the flight ends at 30 s"),
        (LATE, "at: 1 s, do: hold, not_before: 40 s", "not_before_s", "hold is kept until 40.00 s, and the flight"),
        (LATE, "at: 1 s, do: hold, expires: 2 s", "expires_s", "hold expires at 2 s, and arrives at about 3.00 s"),
        (CLOSED, "at: 10 s, do: hold", "at_s", "hold is never sent: no contact up has room for it from 10 s on"),
    ],
)
def test_what_comes_too_late_is_found(more: str, command: str, field: str, text: str) -> None:
    ((kind, path, said),) = found(more, f"{{at: 1 s, do: set_timeout, timeout: 60 s}}, {{{command}}}")
    assert (kind, path) == ("schedule", ("schedule", 1, field))
    assert said.startswith(text)


@pytest.mark.parametrize(
    ("more", "command"),
    [
        (LATE, "at: 28 s, do: hold"),  # arrives as the flight ends
        (LATE, "at: 1 s, do: hold, not_before: 30 s"),
        (LATE, "at: 1 s, do: set_timeout, timeout: 60 s, expires: 3 s"),
        (CLOSED, "at: 8 s, do: set_timeout, timeout: 60 s"),
        ("link: {up: {loss: 1}}\n", "at: 9 s, do: hold, expires: 10 s"),  # the link says so itself
        (FENCE, "at: 60 s, do: go_to, position: [5 m, 19 m]"),
    ],
)
def test_what_may_just_be_obeyed_is_not(more: str, command: str) -> None:
    assert found(more, f"{{{command}}}") == []


def test_a_place_outside_the_fence_is_found() -> None:
    assert found(FENCE, "{at: 1 s, do: go_to, position: [5 m, 21 m]}") == [
        ("fence", ("schedule", 0, "position_m"), "(5, 21) is outside keep-in: the robot will reject it")
    ]


def test_what_is_over_once_it_is_obeyed_cannot_be_cancelled() -> None:
    go_to = "{at: 2 s, do: go_to, position: [1 m, 1 m], not_before: 20 s}"
    change = "{at: 1 s, do: set_timeout, timeout: 60 s%s}"
    cancelled = f"{{at: 9 s, do: cancel, command: %d}}, {go_to}, {change}"
    assert [path for _, path, _ in found("", cancelled % (2, ""))] == [("schedule", 0, "command")]
    ((_, _, text),) = found("", cancelled % (2, ""))
    assert text == "command 2 is the set_timeout of 1 s, which is over once it is obeyed"
    assert found("", cancelled % (2, ", not_before: 20 s")) == []
    assert found("", cancelled % (3, "")) == []  # the way to a place
    none = "expect: {reached: 0}\n"
    assert found(none, cancelled % (1, "")) == []  # the plan
    assert found(f"autonomy: waypoint\n{none}", cancelled % (2, "")) == []  # its own commands come in between


@pytest.mark.parametrize(
    ("autonomy", "command"),
    [
        ("waypoint", {"do": "release", "released": 1}),
        ("heading", {"do": "release", "released": 1}),
        ("joint", {"do": "release", "released": 1}),
        ("joint", {"do": "skip"}),
        ("joint", {"do": "set_tolerance", "tolerance_m": 1.0}),
        ("joint", {"do": "set_timeout", "timeout_s": 9.0}),
    ],
)
def test_what_is_said_to_do_nothing_does_nothing(autonomy: str, command: dict[str, object]) -> None:
    far = {"position_m": [500.0, 0.0], "timeout_s": 1.0}
    schedule = [{"at_s": 0.5} | command]
    without = mission_of(far, autonomy=autonomy, expect={"reached": 0})
    mission = mission_of(far, autonomy=autonomy, expect={"reached": 0}, schedule=schedule)
    ((field, text),) = [(each.path[-1], each.text) for each in of(mission)]
    assert field == "do"
    assert text.startswith(f"{command['do']} does nothing under autonomy {autonomy}: ")
    states = [
        [(state.time_ns, state.qpos.tobytes()) for state in only(State, flown(each)[1])] for each in (without, mission)
    ]
    assert states[0] == states[1]
    assert len(states[0]) > 40


def test_an_abort_does_not_stop_a_pilot_and_a_hold_does() -> None:
    def stood(do: str) -> tuple[int, list[str]]:
        schedule = [{"at_s": 0.5, "do": do}]
        mission = mission_of(
            {"position_m": [500.0, 0.0]}, autonomy="joint", schedule=schedule, expect={"max_time_s": 1.5}
        )
        _, messages = flown(mission)
        sources = [action.source for action in only(Action, messages)]
        texts = [each.text for each in of(mission)]
        return sources.count("stance"), texts

    steps, texts = stood("abort")
    assert steps <= 1
    assert texts == [
        "abort does nothing under autonomy joint: the pilot's next action takes the motors again; hold stops it"
    ]
    steps, texts = stood("hold")
    assert steps >= 49
    assert texts == ["no command follows this hold: the mission never ends"]


def test_a_release_is_obeyed_where_a_plan_is_on_board() -> None:
    schedule = [{"at_s": 0.5, "do": "release", "released": -1}]
    mission = mission_of(UNDER_FOOT, UNDER_FOOT, schedule=schedule, operator={"released": 1})
    assert of(mission) == []
    result, messages = flown(mission)
    assert result.outcome == "success", result.reason
    final = {each.command_id: each.stage for each in only(CommandStage, messages) if each.stage in FINAL_STAGES}
    assert final[2] is Stage.COMPLETED


@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "heading", "joint"])
@pytest.mark.parametrize("do", ["abort", "return_home", "go_to"])
def test_a_command_that_the_mission_fails_by_is_found(autonomy: str, do: str) -> None:
    place = {"position_m": [0.0, 0.0], "tolerance_m": 50.0} if do == "go_to" else {}
    schedule = [{"at_s": 0.5, "do": do} | place]
    far = {"position_m": [60.0, 0.0], "timeout_s": 300.0}
    mission = mission_of(far, autonomy=autonomy, schedule=schedule, expect={"max_time_s": 5.0})
    texts = [each.text for each in of(mission) if "the mission is expected to fail" in each.text]
    result, _ = flown(mission)
    assert bool(texts) == (autonomy != "joint")
    assert result.reason.startswith("longer than 5 s") == (autonomy == "joint"), "a pilot goes on"
    if texts:
        assert texts[0].startswith(f"the mission is expected to fail by this {do}, at about ")
        assert texts[0].endswith(", 0 of 1 waypoint reached; if that is meant, set expect.reached")
        assert of(mission_of(far, autonomy=autonomy, schedule=schedule, expect={"reached": 0})) == []
        late = [schedule[0] | {"not_before_s": 4_000.0}]
        assert of(mission_of(far, autonomy=autonomy, schedule=late)) == []
