"""What a proof says it compared is what is in the log."""

from __future__ import annotations

from collections import Counter

from tests.replay.rewriting import Flown
from waypointctl.replay.verify import verify


def test_commands_their_stages_and_what_was_heard_are_counted(flown: Flown) -> None:
    counts = Counter(type(message).__name__ for message in flown.messages)
    assert counts["CommandStage"] > counts["Command"] > 1
    said = (
        f"{counts['Command']} commands, {counts['CommandStage']} command stages, {counts['Ack']} acknowledgements and "
        f"{counts['Telemetry']} telemetry frames, with their delivery times"
    )
    assert said in verify(flown.path).checks
