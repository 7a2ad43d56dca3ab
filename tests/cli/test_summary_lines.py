"""What is said, and given as JSON, of ways home, of where the robot ended, and of the link while it flies."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from tests.replay.hand_made import FAR, NEAR, event, flight, frame
from waypointctl.cli.tui.screens import LiveView
from waypointctl.cli.tui.summary import whereabouts_lines
from waypointctl.log.header import ContactWindows, MissionSetting
from waypointctl.log.messages import DeliveryOutcome, EventKind, LinkRecord, Message, Mode
from waypointctl.replay.summary import summary_json
from waypointctl.replay.summary_builder import summarize
from waypointctl.units import NS_PER_S

SETTING = MissionSetting(home=replace(NEAR, x_m=0.0, y_m=0.0))
BEGUN = event(4, EventKind.RETURN_STARTED, "returning home: timeout")
REACHED = event(4.8, EventKind.HOME_REACHED, "home reached")
RETURNING = replace(frame(2, 4.2, 6.1, (0,)), mode=Mode.RETURNING)
STANDING = replace(frame(3, 4.9, 6.2, (0,)), mode=Mode.SAFE)


@pytest.mark.parametrize(
    ("messages", "said"),
    [
        ([BEGUN], "began at 4.00 s (timeout), under way when the flight ended; not known to the operator"),
        (
            [BEGUN, RETURNING, REACHED],
            "began at 4.00 s (timeout), home reached at 4.80 s; its start was known to the operator at 5.20 s",
        ),
        (
            [BEGUN, RETURNING, REACHED, STANDING],
            "began at 4.00 s (timeout), home reached at 4.80 s; known to the operator at 5.90 s",
        ),
    ],
)
def test_a_way_home_is_told_as_it_was_and_as_it_was_known(messages: list[Message], said: str) -> None:
    way, _ = whereabouts_lines(summarize([*flight(), *messages], (NEAR, FAR), SETTING))
    assert way == f"return     {said}"


def test_where_the_robot_ended_and_where_the_operator_last_heard_of_it() -> None:
    # The newest frame of the flight was sampled at 2 s where x was 2 m; at 5 s the robot is at (6.3, 0.4).
    place = "at (6.30, 0.40) m"
    heard = "last known to the operator: (2.00, 0.00) m, sampled at 2.00 s"
    assert whereabouts_lines(summarize(flight())) == [f"ended      {place}; {heard}"]
    *_, line = whereabouts_lines(summarize([*flight(), BEGUN], (), SETTING))
    assert line == f"ended      {place}, 6.31 m from home; {heard}"
    assert whereabouts_lines(summarize([])) == []


def test_a_frame_that_was_overtaken_is_not_the_last_one() -> None:
    late = replace(frame(0, 1.0, 0.5, ()), received_ns=5 * NS_PER_S)
    *_, line = whereabouts_lines(summarize([*flight(), late]))
    assert "(2.00, 0.00) m, sampled at 2.00 s" in line


def test_as_json() -> None:
    summary = summary_json(summarize([*flight(), BEGUN, RETURNING, REACHED, STANDING], (NEAR, FAR), SETTING), "hand")
    assert summary["home"] == {"x_m": 0.0, "y_m": 0.0}
    assert summary["returns_home"] == [
        {
            "cause": "timeout",
            "command": None,
            "began_s": 4.0,
            "began_known_s": 5.2,
            "ending": "home reached",
            "reached": True,
            "ended_s": 4.8,
            "ended_known_s": 5.9,
        }
    ]
    assert summary["ended_at"] == {"x_m": 6.3, "y_m": 0.4, "at_s": 5.0}
    assert summary["believed_at"] == {"x_m": 6.2, "y_m": 0.0, "at_s": 4.9}
    assert summary["home_distance_m"] == pytest.approx(6.3127, abs=1e-4)
    without = summary_json(summarize([]), "hand")
    assert (without["home"], without["returns_home"], without["ended_at"]) == (None, [], None)


def lost(way: str) -> LinkRecord:
    return LinkRecord(0, way, "telemetry", 1, 10, 0, (), DeliveryOutcome.LOST)


def panels(messages: list[Message], setting: MissionSetting) -> str:
    people = Console(file=io.StringIO(), force_terminal=True, width=80, height=24, color_system=None)
    view = LiveView(people, "hand", (NEAR, FAR), setting)
    for message in messages:
        view.flight(message)
    with people.capture() as capture:
        people.print(view.picture())
    return capture.get()


def test_the_live_view_tells_how_the_link_is() -> None:
    assert "link " not in panels(list(flight()), MissionSetting())
    pass_ = ContactWindows(np.array([0]), np.array([3 * NS_PER_S]), 10 * NS_PER_S)
    both = MissionSetting(up=pass_, down=pass_)
    assert "link       closed until 10.00 s" in panels(list(flight()), both)
    assert "link       open until 3.00 s" in panels(list(flight())[:5], both)
    assert "link up    closed until 10.00 s" in panels(list(flight()), MissionSetting(up=pass_))
    over = ContactWindows(np.array([0]), np.array([3 * NS_PER_S]))
    assert "link       closed from now on" in panels(list(flight()), MissionSetting(up=over, down=over))
    lost_spans = event(5, EventKind.LINK_LOST, "link lost after 4 s without a message: hold")
    picture = panels([*flight(), lost("up"), lost("down"), lost("down"), lost_spans], MissionSetting())
    assert "losses     1 up, 2 down" in picture
    assert "link lost  on board, at 5.00 s" in picture
