"""What the prompt answers itself never reaches the operator's station."""

from __future__ import annotations

from typing import Any

import pytest

from tests.flight.operator.missions import mission_of
from waypointctl.cli.tui.prompt import Prompt

YARD = mission_of("onboard: {geofence: {keep_in: [{center: [0 m, 0 m], radius: 20 m}]}}")


class Lines:
    """Lines that have all been typed already; stands in for TypedLines."""

    is_terminal = False
    is_open = True
    draft = ""

    def __init__(self, *lines: str) -> None:
        self._lines = list(lines)

    def read(self, timeout_s: float) -> list[str]:
        lines, self._lines = self._lines, []
        return lines


def taken(*lines: str) -> list[str]:
    typed: Any = Lines(*lines)
    return list(Prompt(YARD, (), typed, 1000.0, lambda: False).lines(0))


def test_what_is_impossible_is_answered_with_what_is_allowed_and_not_sent(capsys: pytest.CaptureFixture[str]) -> None:
    assert taken("tolerance -1", "tolerance 0.5", "goto 30 0", "goto 3 0", "release -2", "quit") == [
        "tolerance 0.5",
        "goto 3 0",
        "quit",
    ]
    assert capsys.readouterr().err.splitlines() == [
        "not sent: tolerance: -1 m is not more than 0 m and at most 100 m; type tolerance 0.5 m, for instance",
        "not sent: goto: (30, 0) is outside keep-in; the mission's geofence allows no goal there",
        "not sent: release: -2 is not a number of waypoints; type 0 or more, or -1 for all",
    ]


def test_what_only_the_robot_can_know_is_sent() -> None:
    lines = ["resume", "skip", "release 9", "cancel 7", "home"]
    assert taken(*lines) == lines
