from __future__ import annotations

import pytest

from waypointctl.errors import MissionError
from waypointctl.mission.files import parse_mission

BASE = "name: n\npolicy: p\nwaypoints: [[7, 12]]\nschedule: "
NAMES = (
    "'go_to', 'hold', 'resume', 'skip', 'cancel', 'abort', 'set_tolerance', 'set_timeout', 'release' or 'return_home'"
)


@pytest.mark.parametrize(
    ("command", "problem"),
    [
        ("{at: 1 s, do: stop}", "4:26: schedule[0].do: 'stop' is not a command; did you mean 'hold' or 'abort'?"),
        ("{at: 1 s, do: goto}", "4:26: schedule[0].do: 'goto' is not a command; did you mean 'go_to'?"),
        ("{at: 1 s, do: RTL}", "4:26: schedule[0].do: 'RTL' is not a command; did you mean 'return_home'?"),
        (
            "{at: 1 s, do: relaese}",
            f"4:26: schedule[0].do: expected one of {NAMES}; got 'relaese'; did you mean 'release'?",
        ),
        ("{at: 1 s, do: bark}", f"4:26: schedule[0].do: expected one of {NAMES}; got 'bark'"),
        ("{at: 1 s, do: 3}", f"4:26: schedule[0].do: expected one of {NAMES}; got 3"),
        ("{at: 1 s, do: set_tolerance}", "4:12: schedule[0]: set_tolerance needs 'tolerance'"),
        ("{at: 1 s, do: set_timeout}", "4:12: schedule[0]: set_timeout needs 'timeout'"),
        ("{at: 1 s, do: cancel}", "4:12: schedule[0]: cancel needs 'command'"),
        (
            "{at: 1 s, do: cancel, command: 9999999999999999999}",
            "4:43: schedule[0].command: must be at most 1,000,000,000; got 9999999999999999999",
        ),
        (
            "{at: 1 s, do: release, released: 9999999999999999999}",
            "4:45: schedule[0].released: must be at most 1,000,000,000; got 9999999999999999999",
        ),
        ("{at: 1 s, do: hold, tolerance_m: 1}", "4:12: schedule[0]: hold does not accept 'tolerance'"),
        (
            "{at: 9 s, do: hold, expires: 5 s}",
            "4:12: schedule[0]: it expires at 5 s, before it can be executed: it is sent at 9 s",
        ),
        (
            "{at: 1 s, do: hold, not_before: 6 s, expires: 5 s}",
            "4:12: schedule[0]: it expires at 5 s, before it can be executed: not before 6 s",
        ),
    ],
)
def test_a_command_is_named_as_the_file_has_it(command: str, problem: str) -> None:
    with pytest.raises(MissionError) as caught:
        parse_mission(f"{BASE}[{command}]\n".encode(), "m.yaml")
    assert str(caught.value) == f"m.yaml:{problem}"
