from __future__ import annotations

import pytest

from tests.studies.standing import cells, line
from waypointctl.studies.claims import ClaimResult, assess_claims, joint_limits
from waypointctl.studies.flights import DelayFlight


def assessed(flown: list[DelayFlight]) -> ClaimResult:
    (only,) = assess_claims(cells(flown), flown)
    return only


@pytest.mark.parametrize(
    ("at_10_s", "finding"), [(20.0, "holds"), (20.99, "holds"), (21.01, "refuted"), (30.0, "refuted")]
)
def test_mission_may_take_one_round_trip_and_5_percent_more(at_10_s: float, finding: str) -> None:
    found = assessed(line("mission", {0.0: [9.0, 11.0], 0.4: [10.4, 10.4], 10.0: [at_10_s, at_10_s]}))
    assert found.finding == finding
    assert found.route == "r"


def test_mission_names_its_worst_round_trip() -> None:
    found = assessed(line("mission", {0.0: [10.0], 5.0: [16.5], 10.0: [20.0]}))
    assert found.found == "at most +10.0%, at 5 s: 16.50 s against 15.00 s"


def test_mission_that_never_comes_through_is_refuted() -> None:
    found = assessed(line("mission", {0.0: [10.0], 5.0: [None]}))
    assert (found.finding, found.found) == ("refuted", "no success at 5 s")


@pytest.mark.parametrize("times_s", [{0.0: [10.0]}, {0.4: [10.0], 5.0: [15.0]}, {0.0: [None], 5.0: [15.0]}])
def test_mission_without_its_zero_is_not_measured(times_s: dict[float, list[float | None]]) -> None:
    assert assessed(line("mission", times_s)).finding == "not measured"


@pytest.mark.parametrize(
    ("a_second", "finding"), [(2.0, "holds"), (2.09, "holds"), (1.88, "refuted"), (2.2, "refuted")]
)
def test_waypoint_grows_by_a_round_trip_for_each_command(a_second: float, finding: str) -> None:
    times_s = {rtt_s: [9 + a_second * rtt_s, 11 + a_second * rtt_s, None] for rtt_s in (0.0, 2.56, 40.0)}
    found = assessed(line("waypoint", times_s, exchanges=2))
    assert found.finding == finding
    assert found.found.startswith(f"{a_second:.2f} ± ")
    assert found.found.endswith("2 commands waited for")


def test_waypoint_at_one_round_trip_is_not_measured() -> None:
    assert assessed(line("waypoint", {5.0: [10.0, 11.0], 10.0: [None]})).finding == "not measured"


@pytest.mark.parametrize(
    ("at_moon_s", "finding"), [(30.0, "holds"), (25.0, "holds"), (24.9, "refuted"), (None, "refuted")]
)
def test_short_range_goal_is_slower_at_the_moon_than_at_every_near_delay(at_moon_s: float | None, finding: str) -> None:
    assert (
        assessed(line("short_range_goal", {0.0: [5.0], 0.4: [10.0], 2.56: [at_moon_s], 40.0: [1e3]})).finding == finding
    )


def test_short_range_goal_without_the_moon_is_not_measured_and_continuous_is_another_line() -> None:
    assert assessed(line("short_range_goal", {0.0: [5.0], 5.0: [10.0]})).finding == "not measured"
    assert assess_claims(cells(line("short_range_goal-continuous", {0.0: [5.0]})), []) == ()


def joint(**rates: int) -> list[DelayFlight]:
    """Return flights at round trips in ms, so many of ten of which succeed."""
    return line("joint", {int(ms[1:]) / 1000: [10.0] * won + [None] * (10 - won) for ms, won in rates.items()})


@pytest.mark.parametrize(
    ("flown", "finding", "limit"),
    [
        (joint(_0=10, _100=5, _120=4, _140=9), "holds", (0.1, 0.12)),
        (joint(_0=10, _240=5, _260=0), "refuted", (0.24, 0.26)),
        (joint(_0=10, _240=10), "refuted", (0.24, None)),
        (joint(_0=10, _250=0), "holds", (0.0, 0.25)),
        (joint(_0=4, _20=10), "refuted", (None, 0.0)),
        (joint(_0=10, _400=0), "not measured", (0.0, 0.4)),
    ],
)
def test_joint_falls_where_fewer_than_half_succeed(
    flown: list[DelayFlight], finding: str, limit: tuple[float | None, float | None]
) -> None:
    assert assessed(flown).finding == finding
    (found,) = joint_limits(cells(flown))
    assert (found.mostly_succeeds_s, found.mostly_fails_s) == limit


def test_joint_says_how_many_on_either_side() -> None:
    text = "5 of 10 succeed at 0.1 s, 4 of 10 succeed at 0.12 s"
    assert assessed(joint(_0=10, _120=4, _100=5)).found == text


def test_each_route_has_its_claims() -> None:
    flown = line("mission", {0.0: [10.0], 5.0: [15.0]})
    flown += [one.model_copy(update={"route": "q", "time_s": 2 * one.time_s}) for one in flown]
    assert [(one.route, one.finding) for one in assess_claims(cells(flown), flown)] == [
        ("r", "holds"),
        ("q", "refuted"),
    ]
