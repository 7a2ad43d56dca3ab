from __future__ import annotations

import json
from dataclasses import asdict, replace
from functools import partial
from typing import Any

from waypointctl.flight.link.direction import Direction
from waypointctl.flight.link.frames import Heartbeat, link_state
from waypointctl.log.messages import Ack, Command, CommandKind, Mode, PlannedWaypoint, Stage, Telemetry

S = 10**9
WAYPOINT = PlannedWaypoint(0, "a", 1.0, 2.0, "box", 0.5, 9 * S, 0, "observe")
COMMAND = Command(1, CommandKind.UPLOAD_PLAN, (WAYPOINT, WAYPOINT), "abort", 0, S, released=1, expires_ns=5)
FRAME = Telemetry(0, Mode.NAVIGATING, 1.0, 2.0, 0.5, 0.1, 1.5, 0, (0, 1), 0, S)


def _same(message: Any, _: int) -> Any:
    return message


def sent(*messages: Any) -> Direction[Any]:
    way: Direction[Any] = Direction(delay=lambda _: S)
    for message in messages:
        way.send(0, 10, partial(_same, message))
    return way


def test_commands_and_acknowledgements_under_way_are_told_whole_and_of_frames_the_first_and_the_last() -> None:
    acks = [Ack(1, stage, "why", 0, S) for stage in (Stage.RECEIVED, Stage.STARTED)]
    up = sent(COMMAND, Heartbeat(0, 0, S), replace(COMMAND, id=2, waypoints=()))
    down = sent(FRAME, acks[0], replace(FRAME, frame=1), acks[1], replace(FRAME, frame=2))
    state: Any = link_state(up, down)
    assert json.dumps(state["up"]["commands"]) == json.dumps(
        [asdict(COMMAND), asdict(replace(COMMAND, id=2, waypoints=()))]
    )
    assert json.dumps(state["down"]["acks"]) == json.dumps([asdict(ack) for ack in acks])
    assert state["down"]["frames"] == [0, 2]
    assert (state["up"]["free_ns"], state["down"]["last_arrival_ns"]) == (0, S)


def test_an_empty_link_has_nothing_under_way() -> None:
    state: Any = link_state(sent(), sent(FRAME))
    assert (state["up"]["commands"], state["down"]["acks"], state["down"]["frames"]) == ([], [], [0])


def test_of_two_frames_under_way_both_are_named() -> None:
    state: Any = link_state(sent(), sent(FRAME, replace(FRAME, frame=1)))
    assert state["down"]["frames"] == [0, 1]
