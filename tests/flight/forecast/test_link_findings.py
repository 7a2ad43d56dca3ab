from __future__ import annotations

import re
from pathlib import Path

import pytest

from waypointctl.flight.forecast.forecast import Forecast, WalkingSpeed, forecast
from waypointctl.flight.forecast.joint import FALLS_FROM_RTT_S
from waypointctl.mission.files import parse_mission

ROOT = Path(__file__).parents[3]
BASE = "name: n\npolicy: p\n"
ONE = BASE + "waypoints: [[8, 6]]\n"


def told(text: str) -> Forecast:
    return forecast(parse_mission(text.encode(), "m.yaml"), WalkingSpeed(2.0, "assumed"))


def kinds(text: str) -> list[tuple[str, tuple[str | int, ...]]]:
    return [(finding.kind, finding.path) for finding in told(text).findings]


@pytest.mark.parametrize(
    ("up", "found"),
    [
        ("windows: [{from: 1 s, to: 3 s}, {from: 5 s, to: 50 s}], rate: 200 bit/s", ["contact"]),
        ("windows: [{from: 5 s, to: 50 s}], rate: 200 bit/s", []),
        ("windows: [{from: 1 s, to: 3 s}], rate: 200 bit/s", ["contact"]),
        ("windows: [{from: 5 s, to: 50 s}], queue: 10 B", ["queue"]),
        ("queue: 10 B", []),
        ("windows: [{from: 0 s, to: 5 s}, {from: 9 s, to: 50 s}], queue: 10 B", ["queue"]),
        ("windows: [{from: 0 s, to: 5 s}], windows_every: 9 s, queue: 10 B", ["queue"]),
    ],
)
def test_contacts_that_are_too_short_are_found(up: str, found: list[str]) -> None:
    assert [kind for kind, _ in kinds(ONE + f"link: {{up: {{{up}}}}}\n")] == found


@pytest.mark.parametrize(
    ("down", "found"),
    [
        ("queue: 10 B", []),  # what need not wait needs no queue
        ("queue: 70 B, rate: 9600 bit/s", ["a frame of telemetry has 8\\d: what"]),
        ("queue: 60 B, windows: [{from: 1 s, to: 50 s}]", ["an acknowledgement has 64, a frame of telemetry has"]),
        (
            "rate: 1 kbit/s, windows: [{from: 0 s, to: 0.52 s}], windows_every: 1 s",
            ["a frame .* fits in no contact down"],
        ),
        ("rate: 1 kbit/s, windows: [{from: 0 s, to: 0.5 s}], windows_every: 1 s", ["an ack.* fits in no contact down"]),
    ],
)
def test_what_the_robot_sends_needs_room(down: str, found: list[str]) -> None:
    findings = told(f"{ONE}telemetry: {{rate: 0.1 Hz}}\nlink: {{down: {{{down}}}}}\n").findings
    assert [finding.path[:2] for finding in findings] == [("link", "down")] * len(found)
    for finding, text in zip(findings, found, strict=True):
        assert re.search(text, finding.text)


@pytest.mark.parametrize(
    ("link", "place", "said"),
    [
        (
            "{down: {delay: 1 s, windows: [{from: 0 s, to: 3 s}]}}",
            ("link", "down", "windows"),
            "the robot's answer (64 bytes) is ready at 5.0 s and fits in no contact down from then on; the last ends "
            "at 3 s: the operator never hears of it",
        ),
        ("{loss: 1}", ("link", "up", "loss"), "every message is lost, both ways: no command ever arrives, and"),
        (
            "{up: {rate: 1 kbit/s, windows: [{from: 0 s, to: 10 ms}]}}",
            ("link", "up", "windows"),
            "the largest command (126 bytes) fits in no contact up: nothing of it will ever arrive",
        ),
    ],
)
def test_what_is_never_to_end_has_one_reason(link: str, place: tuple[str, ...], said: str) -> None:
    found = told(f"{ONE}link: {link}\n")
    assert found.own.time_s is None
    (finding,) = found.findings
    assert finding.path == place
    assert finding.text.startswith(said)


def test_a_second_command_may_find_no_contact() -> None:
    text = (
        f"{BASE}autonomy: waypoint\nwaypoints: [[8, 6], [8, 16]]\nlink: {{up: {{windows: [{{from: 0 s, to: 3 s}}]}}}}\n"
    )
    (finding,) = told(text).findings
    assert finding.path == ("link", "up", "windows")
    assert re.fullmatch(
        r"a command \(\d+ bytes\) is ready at 5.0 s and fits in no contact up from then on; the last ends at 3 s: "
        "the mission stops there",
        finding.text,
    )


def test_a_contact_plan_is_where_its_contacts_are_found_short() -> None:
    plan = b"a contact +0 +9 1 2 100\na contact +0 +3 2 1 100\na range +0 +9 1 2 1\n"
    text = ONE + "telemetry: {rate: 0.1 Hz}\nlink: {contact_plan: {file: plan, from_node: 1, to_node: 2}}\n"
    found = forecast(parse_mission(text.encode(), "m.yaml", {"plan": plan}), WalkingSpeed(2.0, "assumed"))
    assert found.own.time_s is None
    assert [finding.path for finding in found.findings] == [("link", "down", "contact_plan")]


def test_a_pilot_too_far_away_is_told_what_the_study_found() -> None:
    (finding,) = told(ONE + "autonomy: joint\nlink: {preset: moon}\n").findings
    assert finding.text == (
        "autonomy joint over a round trip of 2.56 s: every flight of the delay study fell from 0.04 s on "
        "(docs/delay.md); choose autonomy mission, waypoint or heading"
    )
    assert kinds(ONE + "autonomy: joint\nlink: {delay: 20 ms}\n") == [("delay", ("autonomy",))]
    assert kinds(ONE + "autonomy: joint\nlink: {delay: 19 ms}\n") == []
    assert kinds(ONE + "autonomy: joint\nlink: {delay: 15 ms, rate: 180 kbit/s}\n") == [("delay", ("autonomy",))]


def test_the_study_still_finds_what_is_quoted_of_it() -> None:
    study = (ROOT / "docs" / "delay.md").read_text().partition("**joint, by round trip**")[2]
    rows = [line.split("|") for line in study.splitlines() if re.match(r"\| 0", line)]
    rates = {float(cells[1]): (cells[2].strip(), cells[6].strip()) for cells in rows}
    assert len(rates) > 5
    for round_trip_s, reached in rates.items():
        assert (reached == ("0/20", "0/20")) == (round_trip_s >= FALLS_FROM_RTT_S)


def test_windows_further_apart_than_a_loss_of_the_link_are_found() -> None:
    rules = "onboard: {link_loss: {after: 5 s}}\noperator: {heartbeat: 1 s}\n"
    windows = "link: {{up: {{windows: [{{from: 0 s, to: {} s}}], windows_every: 10 s}}}}\n"
    assert kinds(ONE + rules + windows.format(6)) == []
    assert kinds(ONE + rules + windows.format(4)) == [("heartbeat", ("onboard", "link_loss"))]


def test_a_rule_that_the_mission_is_over_before_needs_no_heartbeats() -> None:
    rules = "onboard: {{link_loss: {{after: {} s}}}}\n"
    assert kinds(ONE + rules.format(2)) == [("heartbeat", ("onboard", "link_loss"))]
    assert kinds(ONE + rules.format(60)) == []
