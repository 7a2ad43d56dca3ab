"""What stays in sight at the console, on terminals of any size."""

from __future__ import annotations

import io
from collections.abc import Callable

import pytest

from tests.replay.rewriting import Flown, fly_once
from waypointctl.cli.tui.screens import ConsoleScreen, console_sizes
from waypointctl.cli.tui.terminal import PrintableConsole
from waypointctl.flight.header import setting_of
from waypointctl.flight.operator.requests import planned_waypoints
from waypointctl.log.messages import Telemetry
from waypointctl.policy.bundle import LoadedPolicy


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Flown:
    folder = tmp_path_factory.mktemp("flight")
    return fly_once(folder, make_policy(folder / "policy", seed=7))


def picture_of(flown: Flown, width: int, height: int, told: int | None = None) -> list[str]:
    """Return the lines of the picture of a screen that was told some messages."""
    people = PrintableConsole(file=io.StringIO(), width=width, height=height, force_terminal=True, color_system=None)
    mission = flown.mission_file.mission
    screen = ConsoleScreen(people, mission.name, planned_waypoints(mission), setting_of(mission))
    for message in flown.messages[:told]:
        screen(message)
    screen.prompt = "> goto 3 m 4"
    with people.capture() as shown:
        people.print(screen.picture())
    return shown.get().splitlines()


@pytest.mark.parametrize(("width", "height"), [(80, 24), (120, 40), (60, 20), (200, 60)])
def test_map_commands_and_what_is_typed_are_in_sight(flown: Flown, width: int, height: int) -> None:
    lines = picture_of(flown, width, height)
    shown = "\n".join(lines)
    assert len(lines) <= height - 4, "what is told has lines to scroll through"
    assert max(map(len, lines)) <= width
    assert lines[-1].startswith("> goto 3 m 4")
    assert "● robot" in shown
    assert "# command" in shown
    assert "go_to there" in shown
    assert "round trip" in shown


@pytest.mark.parametrize("height", [1, 2, 3, 5, 8, 12, 15, 19])
@pytest.mark.parametrize("width", [1, 2, 5, 13, 30, 55, 57])
def test_on_a_small_terminal_what_is_typed_stays_in_sight(flown: Flown, width: int, height: int) -> None:
    lines = picture_of(flown, width, height)
    assert len(lines) <= max(2, height - 4)
    assert all(len(line) <= width for line in lines)
    plan = console_sizes(width, height)
    assert plan.map_columns <= width
    if width > 13:
        assert lines[-1].startswith("> goto 3 m 4")


def test_nothing_is_shown_that_was_not_heard(flown: Flown) -> None:
    first = next(at for at, message in enumerate(flown.messages) if isinstance(message, Telemetry))
    lines = picture_of(flown, 80, 24, first)
    shown = "\n".join(lines)
    assert "0 of 3 reached, 0 known" in shown
    assert "no telemetry yet" in shown
    assert "robot" not in shown.replace("● robot", "")


def test_what_is_told_is_broken_between_words() -> None:
    people = PrintableConsole(file=io.StringIO(), width=30, height=20, force_terminal=True, color_system=None)
    screen = ConsoleScreen(people, "t", (), setting=None)  # type: ignore[arg-type]
    with people.capture() as shown:
        screen.say("not sent: tolerance: -1 m is not more than 0 m and at most 100 m")
    lines = shown.get().splitlines()
    assert max(map(len, lines)) <= 30
    assert (
        " ".join(line.strip() for line in lines) == "not sent: tolerance: -1 m is not more than 0 m and at most 100 m"
    )
