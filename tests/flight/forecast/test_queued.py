"""Acknowledgements behind telemetry: what is told against what is flown."""

from __future__ import annotations

from pathlib import Path

import pytest

from waypointctl.evaluation.walking_speed import walking_speed
from waypointctl.flight.fly import fly
from waypointctl.flight.forecast.forecast import Forecast, forecast
from waypointctl.mission.files import parse_mission
from waypointctl.policy.bundle import load_policy

POLICY = Path(__file__).parents[3] / "policies" / "ant-waypoint"
HEAD = "name: n\npolicy: p\nwaypoints: [[5, 0], [5, 5]]\n"


def told(text: str) -> Forecast:
    return forecast(parse_mission((HEAD + text).encode(), "m.yaml"), walking_speed(POLICY))


def rate_texts(found: Forecast) -> list[str]:
    return [finding.text for finding in found.findings if finding.kind == "rate"]


def test_the_wait_behind_telemetry_is_in_the_time() -> None:
    text = "telemetry: {rate: 10 Hz}\nlink: {delay: 1.28 s, rate: 2 kbit/s}\n"
    found, flown = told(text), fly(parse_mission((HEAD + text).encode(), "m.yaml"), load_policy(POLICY), lambda _: None)
    assert flown.outcome == "success"
    assert found.own.time_s == pytest.approx(flown.known_ns / 1e9, rel=0.15)
    (warned,) = rate_texts(found)
    assert "what is too much waits, and acknowledgements behind it" in warned
    assert "s longer by it" in warned


@pytest.mark.parametrize(
    "text",
    [
        "link: {delay: 1.28 s, rate: 100 bit/s}\n",
        "autonomy: waypoint\ntelemetry: {rate: 10 Hz}\nlink: {delay: 1.28 s, rate: 2 kbit/s}\n",
    ],
)
def test_answers_that_come_after_the_last_retry_are_waited_for(text: str) -> None:
    found, flown = told(text), fly(parse_mission((HEAD + text).encode(), "m.yaml"), load_policy(POLICY), lambda _: None)
    assert flown.outcome == "success"
    assert found.own.time_s == pytest.approx(flown.known_ns / 1e9, rel=0.2)
    assert "s longer by it" in rate_texts(found)[0]


def test_a_link_that_carries_its_telemetry_adds_nothing() -> None:
    fast, free = told("link: {up: {delay: 1 s}, down: {delay: 1 s, rate: 1 Mbit/s}}\n"), told("link: {delay: 1 s}\n")
    assert rate_texts(fast) == []
    assert fast.own.time_s == pytest.approx(free.own.time_s, abs=0.01)


def test_under_joint_it_is_not_counted() -> None:
    found = told("autonomy: joint\nlink: {rate: 1 kbit/s}\n")
    assert ("telemetry in the queue" in found.not_counted) == (found.own.time_s is not None)
