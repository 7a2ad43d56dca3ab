from __future__ import annotations

from tests.flight.flying import UNDER_FOOT, flown, mission_of
from waypointctl.flight.outcome import SILENT


def test_a_flight_whose_only_command_is_lost_and_never_sent_again_ends() -> None:
    result, _ = flown(mission_of(UNDER_FOOT, commands={"acknowledged": False}, link={"up": {"loss": 1.0}, "down": {}}))
    assert result.outcome == "failure"
    assert result.reason.startswith(SILENT)


def test_so_does_one_whose_answer_has_no_contact_left() -> None:
    down = {"delay_s": 1.0, "windows": [{"from_s": 0.0, "to_s": 0.5}]}
    result, _ = flown(mission_of(UNDER_FOOT, link={"up": {"delay_s": 1.0}, "down": down}))
    assert (result.outcome, result.waypoints_reached) == ("failure", 0)
    assert result.reason.startswith("no acknowledgement of command 1 (upload_plan WP1): 0 of 1 waypoints reached in ")


def test_a_command_that_is_lost_each_time_is_given_up_before_that() -> None:
    result, _ = flown(mission_of(UNDER_FOOT, link={"up": {"loss": 1.0, "delay_s": 1.0}, "down": {"delay_s": 1.0}}))
    assert result.reason.startswith("no acknowledgement of command 1 (upload_plan WP1): 0 of 1 waypoints reached")
    assert result.sim_time_ns == 4 * 3_020_000_000, "four times a round trip, a control period and the margin"


def test_a_long_wait_is_not_silence() -> None:
    result, _ = flown(mission_of(UNDER_FOOT, UNDER_FOOT, autonomy="waypoint", delay_ms=3_600_000.0))
    assert result.outcome == "success"
