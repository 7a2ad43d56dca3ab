from __future__ import annotations

from typing import Any

import pytest

from tests.flight.flying import mission_of
from waypointctl.flight.forecast.delivery import delivered, delivery_findings
from waypointctl.flight.forecast.duration import Expected, expected
from waypointctl.flight.forecast.rehearsal import rehearse
from waypointctl.flight.forecast.traffic import Traffic, traffic_of
from waypointctl.mission.mission import Mission

SPEED_MPS = 2.0
SEEDS = range(2_000, 2_100)
PLACES = ({"position_m": [9.0, 0.0]}, {"position_m": [9.0, 9.0]}, {"position_m": [0.0, 9.0]})
BURSTS = {"p": 0.2, "r": 0.4}


def over(up: Any, down: Any, retries: int, autonomy: str = "waypoint", **changes: Any) -> Mission:
    link = {"up": {"delay_s": 1.28, "loss": up}, "down": {"delay_s": 1.28, "loss": down}}
    telemetry = {"rate_hz": 1.0, "beacon_s": 5.0}
    commands = {"retries": retries} | changes
    return mission_of(*PLACES, autonomy=autonomy, link=link, commands=commands, telemetry=telemetry)


def asked(mission: Mission) -> tuple[Traffic, Expected]:
    traffic = traffic_of(mission)
    return traffic, expected(mission, SPEED_MPS, traffic, mission.autonomy)


@pytest.mark.parametrize(
    ("up", "down", "retries", "autonomy"),
    [
        (0.6, 0.0, 0, "mission"),
        (0.6, 0.0, 2, "waypoint"),
        (0.3, 0.3, 1, "waypoint"),
        (0.0, 0.7, 1, "waypoint"),
        (BURSTS, 0.0, 1, "waypoint"),
        (BURSTS, BURSTS, 3, "mission"),
    ],
)
def test_missions_get_through_as_often_as_they_do_on_the_link_that_is_flown(
    up: Any, down: Any, retries: int, autonomy: str
) -> None:
    mission = over(up, down, retries, autonomy)
    traffic, own = asked(mission)
    good = 0
    for seed in SEEDS:
        rehearsed = rehearse(mission.model_copy(update={"seed": seed}), SPEED_MPS, 20.0, losses=True)
        assert rehearsed is not None
        good += rehearsed.good
    assert delivered(mission, traffic, own) == pytest.approx(good / len(SEEDS), abs=0.11)


def test_what_is_likely_to_be_lost_is_found_with_a_number_of_retries_that_helps() -> None:
    mission = over(0.6, 0.0, 0, "mission")
    (found,) = delivery_findings(mission, *asked(mission))
    assert (found.kind, found.path) == ("loss", ("commands", "retries"))
    assert found.text == (
        "with 0 retries, the probability that the plan is delivered and acknowledged is 40 %; a command that is never "
        "acknowledged stays unknown, and the mission fails once nothing more is heard; with 8 retries the probability "
        "is 99.0 %"
    )
    better = over(0.6, 0.0, 8, "mission")
    assert list(delivery_findings(better, *asked(better))) == []
    assert delivered(better, *asked(better)) == pytest.approx(1 - 0.6**9)


def test_without_acknowledgements_nothing_is_sent_again() -> None:
    mission = over(0.3, 0.0, 3, "mission", acknowledged=False)
    assert delivered(mission, *asked(mission)) == pytest.approx(0.7)
    (found,) = delivery_findings(mission, *asked(mission))
    assert found.path == ("commands", "acknowledged")


@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "heading"])
def test_over_a_link_that_is_lost_at_once_nothing_gets_through(autonomy: str) -> None:
    mission = over({"p": 1.0, "r": 0.0}, {"p": 1.0, "r": 0.0}, 3, autonomy)
    assert delivered(mission, *asked(mission)) == 0
    rehearsed = rehearse(mission, SPEED_MPS, 20.0, losses=True)
    assert rehearsed is not None
    assert not rehearsed.good


def test_where_nothing_is_lost_all_gets_through() -> None:
    mission = over(0.0, 0.0, 0)
    assert delivered(mission, *asked(mission)) == 1
    assert list(delivery_findings(mission, *asked(mission))) == []
