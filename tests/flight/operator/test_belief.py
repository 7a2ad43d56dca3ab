"""What the operator knows, of messages that the link brings in any order."""

from __future__ import annotations

from dataclasses import replace

from tests.flight.operator.channel import ack, frame
from waypointctl.flight.belief import Belief
from waypointctl.log.messages import Mode, Stage


def test_a_frame_that_arrives_out_of_order_is_not_taken_for_the_newest() -> None:
    belief = Belief()
    newer = replace(frame(Mode.DONE), frame=5, reached=(0, 1))
    belief.hear(newer)
    belief.hear(replace(frame(Mode.RETURNING), frame=4, reached=(0,)))
    assert belief.telemetry == newer
    assert belief.went_home, "a way home that is over is still one"
    assert belief.knows_reached(1)


def test_no_acknowledgement_follows_a_final_one() -> None:
    belief = Belief()
    belief.hear(replace(ack(Stage.FAILED), reason="timeout", issued_ns=7))
    belief.hear(replace(ack(Stage.STARTED), issued_ns=8))
    assert (belief.stages, belief.reasons, belief.ended_ns) == ({1: Stage.FAILED}, {1: "timeout"}, 7)
    assert not belief.is_whole
    belief.hear(replace(frame(Mode.FAILED), issued_ns=7))
    assert belief.is_whole
