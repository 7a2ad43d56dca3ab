from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.ops.ground.missions import mission_of
from waypointctl.log.messages import CommandKind
from waypointctl.ops.ground.console import order_from
from waypointctl.ops.ground.order import Order

MISSION = mission_of("defaults: {tolerance: 0.3 m, timeout: 12 s}")


def test_each_command_becomes_its_order() -> None:
    assert order_from("hold", MISSION) == Order(CommandKind.HOLD)
    assert order_from("  home ", MISSION) == Order(CommandKind.RETURN_HOME)
    assert order_from("cancel 3", MISSION) == Order(CommandKind.CANCEL, target_id=3)
    assert order_from("release 2", MISSION) == Order(CommandKind.RELEASE, released=2)
    assert order_from("tolerance 0.25", MISSION) == Order(CommandKind.SET_TOLERANCE, value=0.25)
    (place,) = order_from("goto 7 -12.5", MISSION).waypoints
    assert (place.x_m, place.y_m, place.tolerance_m, place.timeout_ns) == (7.0, -12.5, 0.3, 12_000_000_000)
    assert place.index < 0, "it is none of the mission's waypoints"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("goto 7", "goto takes X Y, not '7'"),
        ("goto a b", "goto takes X Y, not 'a b'"),
        ("goto nan 1", "goto takes X Y"),
        ("goto 1e9 0", "further than 10000 m"),
        ("hold 3", "hold takes nothing after it"),
        ("cancel 1.5", "1.5 is not a whole number"),
        ("jump", "'jump' is no command here; there are: goto X Y"),
    ],
)
def test_what_is_no_command_is_refused_with_what_there_is(line: str, said: str) -> None:
    with pytest.raises(ValueError, match=said.replace("(", r"\(")):
        order_from(line, MISSION)


@given(st.text(min_size=1).filter(str.strip))
@settings(max_examples=200, deadline=None)
def test_any_line_is_an_order_or_refused(line: str) -> None:
    with suppress(ValueError):  # refused; nothing else may be raised
        assert order_from(line, MISSION).words
