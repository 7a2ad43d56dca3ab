from __future__ import annotations

from typing import Any

import pytest

from tests.flight.flying import mission_of
from waypointctl.flight.forecast.duration import Expected, expected
from waypointctl.flight.forecast.heartbeats import heartbeat_findings, taken_for_lost
from waypointctl.flight.forecast.rehearsal import rehearse
from waypointctl.flight.forecast.traffic import traffic_of
from waypointctl.mission.mission import Mission

SPEED_MPS = 2.0
SEEDS = range(2_000, 2_100)


def beating(loss: Any, beat_s: float, after_s: float, do: str = "return_home") -> Mission:
    return mission_of(
        {"position_m": [30.0, 0.0]},
        link={"up": {"delay_s": 0.5, "loss": loss}, "down": {"delay_s": 0.5}},
        commands={"retries": 50},
        telemetry={"rate_hz": 1.0},
        operator={"heartbeat_s": beat_s},
        onboard={"link_loss": {"after_s": after_s, "do": do}},
    )


def own(mission: Mission) -> Expected:
    return expected(mission, SPEED_MPS, traffic_of(mission), "mission")


@pytest.mark.parametrize(
    ("loss", "beat_s", "after_s"),
    [(0.1, 3.0, 4.0), (0.5, 1.0, 3.5), ({"p": 0.1, "r": 0.4}, 1.0, 2.5), ({"p": 0.3, "r": 0.2}, 3.0, 4.0)],
)
def test_a_link_is_taken_for_lost_as_often_as_on_the_link_that_is_flown(
    loss: Any, beat_s: float, after_s: float
) -> None:
    mission = beating(loss, beat_s, after_s)
    lost = 0
    for seed in SEEDS:
        rehearsed = rehearse(mission.model_copy(update={"seed": seed}), SPEED_MPS, 20.0, losses=True)
        assert rehearsed is not None
        lost += rehearsed.reason == "link lost"
    assert taken_for_lost(mission, own(mission)) == pytest.approx(lost / len(SEEDS), abs=0.11)


def test_a_rule_that_is_likely_to_be_wrong_is_found() -> None:
    mission = beating({"p": 0.3, "r": 0.2}, 3.0, 4.0)
    (found,) = heartbeat_findings(mission, own(mission))
    assert (found.kind, found.path) == ("heartbeat", ("onboard", "link_loss", "after_s"))
    assert found.text.startswith("the link loses one heartbeat within the 16 s expected with a probability of 83%; ")
    assert found.text.endswith("the robot takes it for lost after 4 s: it gives the plan up and walks home")


@pytest.mark.parametrize(
    ("loss", "beat_s", "after_s", "do"),
    [
        (0.0, 3.0, 4.0, "hold"),
        (0.01, 1.0, 3.5, "return_home"),  # three in a row
        (0.5, 1.0, 2.5, "finish"),  # nothing follows
        (0.5, 3.0, 3.0, "hold"),  # the link counts as lost between any two: that is said elsewhere
        (0.5, 30.0, 31.0, "hold"),  # the mission is over before
    ],
)
def test_a_rule_that_is_likely_to_be_right_is_not(loss: float, beat_s: float, after_s: float, do: str) -> None:
    mission = beating(loss, beat_s, after_s, do)
    assert list(heartbeat_findings(mission, own(mission))) == []
