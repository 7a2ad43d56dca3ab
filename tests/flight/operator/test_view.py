"""What the operator knows, of messages that the link brings in any order."""

from __future__ import annotations

from dataclasses import replace

from tests.flight.operator.channel import ack, frame
from waypointctl.flight.operator.view import OperatorView
from waypointctl.log.messages import Mode, Stage


def test_a_frame_that_arrives_out_of_order_is_not_taken_for_the_newest() -> None:
    view = OperatorView()
    newer = replace(frame(Mode.DONE), frame=5, reached=(0, 1))
    view.on_message(newer)
    view.on_message(replace(frame(Mode.RETURNING), frame=4, reached=(0,)))
    assert view.telemetry == newer
    assert view.went_home, "a way home that is over is still one"
    assert view.knows_reached(1)


def test_no_acknowledgement_follows_a_final_one() -> None:
    view = OperatorView()
    view.on_message(replace(ack(Stage.FAILED), reason="timeout", issued_ns=7))
    view.on_message(replace(ack(Stage.STARTED), issued_ns=8))
    assert (view.stages, view.reasons, view.ended_ns) == ({1: Stage.FAILED}, {1: "timeout"}, 7)
    assert not view.is_current
    view.on_message(replace(frame(Mode.FAILED), issued_ns=7))
    assert view.is_current
