"""A logged flight shown again, in real time or a multiple of it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from waypointctl.cli.standard_streams import has_failed
from waypointctl.cli.tui.pace import Pace
from waypointctl.cli.tui.terminal_input import Keyboard
from waypointctl.cli.tui.watch import Watch, watch
from waypointctl.errors import InputError
from waypointctl.log.messages import State
from waypointctl.units import NS_PER_S, ns

if TYPE_CHECKING:
    from waypointctl.replay.flight_log import FlightLog

_NAP_S: Final = 0.05
_STEP_NS: Final = NS_PER_S // 10
_FASTEST: Final = 1024.0
_SLOWEST: Final = 1 / 1024


@dataclass(frozen=True, slots=True)
class Playback:
    """How a flight is to be shown.

    Attributes:
        rate: simulated seconds in a second.
        start_offset_s: from where on, from mission start.
        loop: over and over.
        start_paused: until the space bar is pressed.
    """

    rate: float = 1.0
    start_offset_s: float = 0.0
    loop: bool = False
    start_paused: bool = False


def play(log: FlightLog, playback: Playback, interrupted: Callable[[], bool]) -> None:
    """Show the flight of a log on stderr, until it is over or interrupted; with a terminal, keys steer it.

    Raises:
        InputError: it cannot begin where it should, or be steered as it must be.
    """
    keyboard = Keyboard()
    if playback.start_paused and not keyboard.is_terminal:
        raise InputError("--start-paused needs a terminal as input")
    last_ns = log.end_ns or 0
    if ns(playback.start_offset_s) > last_ns:
        problem = f"the flight is over at {last_ns / NS_PER_S:.2f} s"
        raise InputError(problem, where=str(log.path), hint="Give a smaller --start-offset.")
    with keyboard, watch(log.mission_name, log.waypoints, log.setting) as view:
        player = _Player(view, keyboard, playback, interrupted)
        player.show(log)
        while playback.loop and not player.is_over:
            view.restart()
            player.show(log)


class _Player:
    """Lets the messages of a flight through when it is time for them, and listens to the keyboard."""

    def __init__(self, view: Watch, keyboard: Keyboard, playback: Playback, interrupted: Callable[[], bool]) -> None:
        self._has_quit = False
        self._interrupted = interrupted
        self._view = view
        self._keyboard = keyboard
        self._begin_ns = ns(playback.start_offset_s)
        self._pace = Pace(playback.rate, self._listen)
        self._paused = playback.start_paused
        self._until_ns = self._begin_ns  # paused, the flight goes on to here and stands

    @property
    def is_over(self) -> bool:
        return self._has_quit or self._interrupted() or has_failed(sys.stderr)

    def show(self, log: FlightLog) -> None:
        self._pace.restart(self._begin_ns)
        self._until_ns = self._begin_ns
        for message in log.messages():
            if isinstance(message, State) and message.time_ns >= self._begin_ns:
                self._wait_for(message.time_ns)
            if self.is_over:
                return
            self._view(message)

    def _wait_for(self, time_ns: int) -> None:
        self._listen(0.0)
        self._pace.wait_for(time_ns, lambda: self.is_over or self._paused)
        while self._paused and time_ns > self._until_ns and not self.is_over:
            self._view.say("paused: space, . step, q quit")
            self._listen(_NAP_S)
            self._pace.restart(time_ns)
        if not self._paused:
            self._until_ns = time_ns
            keys = "  space pause, + - rate, q quit" if self._keyboard.is_terminal else ""
            self._view.say(f"x{self._pace.rate:g}{keys}")

    def _listen(self, timeout_s: float) -> None:
        match self._keyboard.read(timeout_s):
            case " ":
                self._paused = not self._paused
            case ".":
                self._until_ns += _STEP_NS
            case "+" | "=":
                self._pace.change(min(self._pace.rate * 2, _FASTEST))
            case "-":
                self._pace.change(max(self._pace.rate / 2, _SLOWEST))
            case "q":
                self._has_quit = True
