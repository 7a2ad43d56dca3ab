from __future__ import annotations

import json

from tests.ops.executive.rig import A, Rig
from waypointctl.log.messages import CommandKind, Stage


def test_a_checkpoint_does_not_grow_with_the_commands_that_have_ended() -> None:
    rig = Rig()
    sizes = {}
    rig.send(0.0, CommandKind.RESUME, id=1, not_before=1e6)
    for number in range(2, 3001):
        rig.send(1.0, CommandKind.GO_TO, A, id=number)
        if number in (2, 200, 300, 3000):
            sizes[number] = len(json.dumps(rig.executive.state()))
    assert sizes[200] > 10 * sizes[2], "while they are few, each is told"
    assert sizes[3000] < 1.05 * sizes[300]
    commands = rig.executive.state()["commands"]
    assert isinstance(commands, dict)
    assert list(commands["records"]) == ["1", *map(str, range(2745, 3001))], "those that are open, and the newest"
    assert commands["older"] == 3000 - 257


def test_what_is_not_in_a_checkpoint_any_more_is_still_obeyed_once() -> None:
    rig = Rig()
    for number in range(1, 400):
        rig.send(1.0, CommandKind.GO_TO, A, id=number)
    rig.send(2.0, CommandKind.GO_TO, A, id=1)
    assert rig.life(1) == [Stage.RECEIVED, Stage.ACCEPTED, Stage.STARTED, Stage.SUPERSEDED]
    assert rig.reminders[-1].stage is Stage.SUPERSEDED
