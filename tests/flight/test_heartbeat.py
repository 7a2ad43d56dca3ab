from __future__ import annotations

from typing import Any

from tests.flight.flying import OUT_OF_REACH, flown, mission_of, times_ns
from waypointctl.log.messages import EventKind
from waypointctl.mission.mission import Mission
from waypointctl.units import NS_PER_S

FAR = OUT_OF_REACH | {"timeout_s": 60.0}


def watched(heartbeat_s: float | None, **link: Any) -> Mission:
    """Return a mission of a minute, whose robot holds when it has heard nothing for ten seconds."""
    operator = {} if heartbeat_s is None else {"heartbeat_s": heartbeat_s}
    up = {"delay_s": 1.0} | link
    onboard = {"link_loss": {"after_s": 10.0, "do": "hold"}}
    expect = {"max_time_s": 90.0}
    return mission_of(FAR, operator=operator, link={"up": up, "down": {}}, onboard=onboard, expect=expect)


def test_heartbeats_keep_the_link() -> None:
    _, messages = flown(watched(5.0))
    assert times_ns(EventKind.LINK_LOST, messages) == []


def test_without_heartbeats_a_robot_that_minds_believes_the_link_lost() -> None:
    _, messages = flown(watched(None))
    assert times_ns(EventKind.LINK_LOST, messages) == [11 * NS_PER_S + 20_000_000], "ten seconds after the plan"


def test_a_window_that_closes_is_a_loss_and_one_that_opens_its_end() -> None:
    windows = [{"from_s": 0.0, "to_s": 20.0}, {"from_s": 50.0, "to_s": 200.0}]
    _, messages = flown(watched(5.0, windows=windows))
    (lost,) = times_ns(EventKind.LINK_LOST, messages)
    (restored,) = times_ns(EventKind.LINK_RESTORED, messages)
    assert lost == 26 * NS_PER_S + 20_000_000, "ten seconds after the heartbeat that left at 15 s"
    assert restored == 51 * NS_PER_S
