"""What the operator knows, of messages that the link brings in any order."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.flight.operator.channel import ack, frame
from waypointctl.flight.operator.operator import ReportedState
from waypointctl.log.messages import Mode, Stage


def test_a_frame_that_arrives_out_of_order_is_not_taken_for_the_newest() -> None:
    reported = ReportedState()
    newer = replace(frame(Mode.DONE), frame=5, reached=(0, 1))
    reported.on_message(newer)
    reported.on_message(replace(frame(Mode.RETURNING), frame=4, reached=(0,)))
    assert reported.telemetry == newer
    assert reported.went_home, "a way home that is over is still one"
    assert reported.reached == (0, 1)
    assert reported.knows_reached(1)


def test_the_state_is_current_when_a_frame_is_no_older_than_the_last_end() -> None:
    reported = ReportedState()
    assert reported.is_current
    reported.on_message(replace(ack(Stage.FAILED), issued_ns=7))
    reported.on_message(replace(ack(Stage.COMPLETED), issued_ns=6))
    reported.on_message(replace(ack(Stage.STARTED), issued_ns=9))
    assert not reported.is_current
    reported.on_message(replace(frame(Mode.FAILED), issued_ns=6))
    assert not reported.is_current
    reported.on_message(replace(frame(Mode.FAILED), frame=1, issued_ns=7))
    assert reported.is_current


def test_an_end_at_mission_start_is_one() -> None:
    reported = ReportedState()
    reported.on_message(ack(Stage.REJECTED))
    assert not reported.is_current
    reported.on_message(replace(frame(Mode.IDLE), issued_ns=0))
    assert reported.is_current


@pytest.mark.parametrize(
    ("mode", "cause", "home"),
    [(Mode.NAVIGATING, "", False), (Mode.RETURNING, "", True), (Mode.SAFE, "at home: stuck", True)],
)
def test_a_way_home_is_known_from_a_frame(mode: Mode, cause: str, home: bool) -> None:
    reported = ReportedState()
    assert reported.reached == ()
    reported.on_message(replace(frame(mode), cause=cause))
    assert reported.went_home is home
