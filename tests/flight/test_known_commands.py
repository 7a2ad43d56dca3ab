"""What the operator knows, by an acknowledgement or by telemetry, it neither sends again nor gives up."""

from __future__ import annotations

from typing import Any

import pytest

from tests.flight.flight_oracle import faults
from tests.flight.flying import OUT_OF_REACH, UNDER_FOOT, flown, mission_of, only
from waypointctl.log.messages import CommandStage, Event, EventKind, Stage
from waypointctl.units import NS_PER_S

BURSTS = {"p": 0.3, "r": 0.3}
THREE = (UNDER_FOOT, UNDER_FOOT, UNDER_FOOT)


def over(up: dict[str, Any], down: dict[str, Any], retries: int, seed: int, **changes: Any) -> Any:
    link = {"up": {"delay_s": 0.5} | up, "down": {"delay_s": 0.5} | down}
    telemetry = {"rate_hz": 5.0, "beacon_s": 10.0}
    return mission_of(*THREE, link=link, commands={"retries": retries}, seed=seed, telemetry=telemetry, **changes)


@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "short_range_goal"])
@pytest.mark.parametrize("down", [{"loss": 0.8}, {"loss": BURSTS}, {"loss": 0.6, "jitter_s": 0.4, "keep_order": False}])
@pytest.mark.parametrize("retries", [0, 2])
def test_whatever_of_the_answers_is_lost_the_mission_goes_on(autonomy: str, down: dict[str, Any], retries: int) -> None:
    mission = over({}, down, retries, 0, autonomy=autonomy)
    result, messages = flown(mission)
    assert (result.outcome, faults(mission, result, messages)) == ("success", [])


@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "short_range_goal"])
@pytest.mark.parametrize("retries", [0, 3])
def test_no_command_is_sent_more_often_than_it_may_be(autonomy: str, retries: int) -> None:
    for seed in range(2):
        schedule = [{"at_s": 2.0, "do": "hold"}, {"at_s": 4.0, "do": "resume"}]
        mission = over({"loss": 0.5}, {"loss": 0.5}, retries, seed, autonomy=autonomy, schedule=schedule)
        result, messages = flown(mission)
        assert faults(mission, result, messages) == []
        attempts = [one.attempt for one in only(CommandStage, messages) if one.stage is Stage.QUEUED]
        assert max(attempts) <= retries + 1


def test_the_reason_names_the_command_of_which_nothing_was_heard() -> None:
    windows = [{"from_s": 0.0, "to_s": 0.9}]
    mission = over({"windows": windows}, {}, 1, 0, autonomy="waypoint")
    result, _ = flown(mission)
    assert result.reason.startswith("no acknowledgement of command 2 (go_to WP2): 1 of 3 waypoints reached in ")


def test_the_reason_says_what_was_heard_where_only_the_end_is_missing() -> None:
    windows = [{"from_s": 0.0, "to_s": 0.55}]
    mission = over({}, {"windows": windows}, 1, 0).model_copy(update={"waypoints": mission_of(OUT_OF_REACH).waypoints})
    result, _ = flown(mission)
    said = "no final stage received for command 1 (upload_plan WP1); its last known stage is started: 0 of 1 waypoints"
    assert result.reason.startswith(said)


def test_where_all_is_known_to_be_reached_the_end_need_not_be_heard_of() -> None:
    held = UNDER_FOOT | {"hold_s": 5.0}
    down = {"delay_s": 0.5, "windows": [{"from_s": 0.0, "to_s": 2.0}]}
    result, _ = flown(mission_of(held, link={"up": {"delay_s": 0.5}, "down": down}))
    assert (result.outcome, result.waypoints_reached) == ("success", 1)


def test_an_end_that_telemetry_tells_is_an_event_of_the_operator_s() -> None:
    mission = over({}, {"loss": 0.8}, 2, 0, autonomy="waypoint")
    _, messages = flown(mission)
    known = [event for event in only(Event, messages) if event.kind is EventKind.COMMAND_KNOWN]
    assert known
    assert all(event.text.endswith("is known from telemetry to be completed") for event in known)
    assert all(event.time_ns > NS_PER_S for event in known)
