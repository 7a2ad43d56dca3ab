from __future__ import annotations

import math
from functools import partial

import pytest

from waypointctl.flight.forecast.duration import AUTONOMIES, Autonomy, expected
from waypointctl.flight.forecast.goals import SETTING_OUT_S
from waypointctl.flight.forecast.traffic import ACK_BYTES, traffic_of, upload_bytes
from waypointctl.flight.forecast.way import walks_of
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Mission

POINT = "tolerance_m: 2.0e-3"  # reached nearly at their very place: 10 m and 10 m
BASE = f"name: n\npolicy: p\nwaypoints: [{{position_m: [8, 6], {POINT}}}, {{position_m: [8, 16], {POINT}}}]\n"
about = partial(pytest.approx, abs=0.01)
START_S = SETTING_OUT_S  # once, from standstill


def parse(more: str = "", text: str = BASE) -> Mission:
    return parse_mission((text + more).encode(), "m.yaml")


def time_s(mission: Mission, autonomy: Autonomy, speed_mps: float = 2.0) -> float | None:
    return expected(mission, speed_mps, traffic_of(mission), autonomy).time_s


@pytest.mark.parametrize(("autonomy", "exchanges"), [("mission", 1), ("waypoint", 2)])
def test_the_formula_of_move_and_wait(autonomy: Autonomy, exchanges: int) -> None:
    mission = parse("link: {up: {delay: 1 s}, down: {delay: 2 s}}\noperator: {think: 5 s}\n")
    found = expected(mission, 2.0, traffic_of(mission), autonomy)
    # L / v + N RTT, and a thought before all but the first
    assert found.time_s == about(START_S + 20 / 2 + exchanges * 3 + (exchanges - 1) * 5)
    assert found.exchanges == exchanges


def test_nobody_balances_a_robot_over_a_long_round_trip() -> None:
    near, far = parse("link: {delay: 10 ms}\n"), parse("link: {up: {delay: 10 ms}, down: {delay: 30 ms}}\n")
    assert time_s(near, "joint") == about(START_S + 20 / 2 + 0.02)
    found = expected(far, 2.0, traffic_of(far), "joint")
    assert (found.time_s, found.falls, found.blocked) == (None, True, None)
    assert not expected(far, 2.0, traffic_of(far), "mission").falls


def test_holds_are_in_it_and_what_is_too_far_for_its_time_is_left_behind() -> None:
    assert time_s(parse("defaults: {hold: 3 s}\n"), "mission") == about(START_S + 10 + 6)
    assert time_s(parse("defaults: {observe: true}\n"), "mission") == about(START_S + 10 + 2)
    skips = parse("defaults: {timeout: 3 s}\non_failure: skip\n")
    assert time_s(skips, "mission") == about(6)
    assert [walk.duration_s for walk in walks_of(skips, 2.0)] == [None, None]
    assert walks_of(skips, 2.0)[1].way_m == about(math.dist((4.8, 3.6), (8, 16)))
    aborts = parse("defaults: {timeout: 3 s}\n")
    assert time_s(aborts, "mission") == about(3)
    assert len(walks_of(aborts, 2.0)) == 1
    retries = parse("defaults: {timeout: 3 s}\non_failure: {retry: 1}\n")
    assert [walk.duration_s for walk in walks_of(retries, 2.0)] == about([5, 5])


def test_contacts_and_rates_count_when_their_time_comes() -> None:
    windows = "windows: [{from: 10 s, to: 20 s}], windows_every: 100 s"
    mission = parse(f"link: {{up: {{{windows}, rate: 1000 bit/s}}, down: {{{windows}}}}}\n")
    # sent at 10 s, there once all of it has left, walked in 10 s, and heard of in the next contact
    left_s = 10 + upload_bytes(mission) * 8 / 1000
    heard_s = left_s + START_S + 10 if left_s + START_S + 10 <= 20 else 110
    assert time_s(mission, "mission") == about(heard_s)
    # the second leg is sent in the first contact too, and ends after it
    assert time_s(mission, "waypoint") == about(110)
    assert time_s(mission, "waypoint", speed_mps=0.9) == about(210)


def test_without_a_contact_it_is_never() -> None:
    mission = parse("link: {up: {windows: [{from: 0 s, to: 10 ms}], rate: 100 bit/s}}\n")
    assert [time_s(mission, autonomy) for autonomy in AUTONOMIES[:3]] == [None, None, None]
    late = parse("link: {down: {windows: [{from: 0 s, to: 5 s}]}}\n")
    assert time_s(late, "mission") is None


def test_very_many_goals_are_told_from_some_of_them() -> None:
    mission = parse("operator: {lookahead: 0.1 m}\nlink: {delay: 1 s}\n", BASE.replace("8, 16", "8, 9999"))
    found = expected(mission, 2.0, traffic_of(mission), "heading")
    assert found.exchanges > 60_000
    assert expected(mission, 2.0, traffic_of(mission), "waypoint").exchanges == 2
    assert found.time_s == pytest.approx(found.exchanges * 2, rel=0.25)


def test_what_never_gets_through_is_known() -> None:
    dead = parse("link: {up: {loss: 1}}\n")
    for autonomy in AUTONOMIES:
        found = expected(dead, 2.0, traffic_of(dead), autonomy)
        assert (found.time_s, found.blocked and (found.blocked.way, found.blocked.ready_s)) == (None, ("up", 0))
    deaf = parse("link: {down: {loss: {p: 0, r: 0, one_minus_k: 1}}}\n")
    found = expected(deaf, 2.0, traffic_of(deaf), "waypoint")
    assert found.blocked is not None
    assert (found.blocked.way, found.blocked.size_bytes) == ("down", ACK_BYTES)
    assert found.blocked.ready_s == about(START_S + 5.0)  # 10 m to the first waypoint
    short = parse("link: {up: {windows: [{from: 1 s, to: 3 s}]}}\n")
    assert time_s(short, "mission") == about(START_S + 1 + 10)
    found = expected(short, 2.0, traffic_of(short), "waypoint")
    assert found.blocked is not None
    assert found.blocked.way == "up"
    assert found.blocked.ready_s == about(START_S + 1 + 5)


def test_a_plan_that_is_not_released_to_its_end_has_none() -> None:
    held = "operator: {released: 1}\n"
    assert time_s(parse(held), "mission") is None
    assert time_s(parse(held), "waypoint") == about(START_S + 10), "the operator releases nothing there"
    for command in ("release, released: -1", "release, released: 2", "abort", "go_to, position: [1 m, 1 m]"):
        assert time_s(parse(f"{held}schedule: [{{at: 1 s, do: {command}}}]\n"), "mission") == about(START_S + 10)
