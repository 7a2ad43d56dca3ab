"""A flight shown at a pace: the pace, what shows it, and a logged flight shown again."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final, Protocol

from waypointctl.cli.console import console, has_failed, is_live
from waypointctl.cli.tui.formatting import happening
from waypointctl.cli.tui.screens import LiveView
from waypointctl.cli.tui.terminal import Keyboard
from waypointctl.errors import InputError
from waypointctl.flight.sink import Sink
from waypointctl.log.header import MissionSetting
from waypointctl.log.messages import Message, PlannedWaypoint, State
from waypointctl.replay.flight_log import FlightLog
from waypointctl.replay.summary_builder import FlightSummaryBuilder
from waypointctl.units import NS_PER_S, ns, seconds

_NAP_S: Final = 0.05  # how long a wait may go without looking whether it is still wanted


class Pace:
    """Lets simulation time pass at `rate` times wall time. It waits; it cannot make up for slow work.

    Attributes:
        rate: simulated seconds in a second.
    """

    def __init__(self, rate: float, idle: Callable[[float], None] = time.sleep) -> None:
        """Start the clock; `idle` is called with how long to wait [s], and may return sooner."""
        self.rate = rate
        self._idle = idle
        self._simulated_s = 0.0
        self._wall_s = time.monotonic()

    @property
    def now_ns(self) -> int:
        """The simulation time that it is, whether or not the simulation has come to it [ns]."""
        return ns(self._simulated_s + (time.monotonic() - self._wall_s) * self.rate)

    def restart(self, time_ns: int) -> None:
        """Say that now is the simulation time `time_ns`."""
        self._simulated_s, self._wall_s = seconds(time_ns), time.monotonic()

    def change(self, rate: float) -> None:
        """Go on from this moment at another rate."""
        now_s = time.monotonic()
        self._simulated_s += (now_s - self._wall_s) * self.rate
        self._wall_s, self.rate = now_s, rate

    def wait_for(self, time_ns: int, stopped: Callable[[], bool] = lambda: False) -> None:
        """Return when it is time for `time_ns`, or when `stopped` returns True."""
        self._catch_up(time_ns)
        while not stopped():
            left_s = self._wall_s + (seconds(time_ns) - self._simulated_s) / self.rate - time.monotonic()
            if left_s <= 0:
                return
            self._idle(min(left_s, _NAP_S))

    def _catch_up(self, time_ns: int) -> None:
        # Time lost, by slow work or while the process was stopped, is not run after: the picture would jump.
        due_s = self._wall_s + (seconds(time_ns) - self._simulated_s) / self.rate
        if time.monotonic() - due_s > 1.0:
            self.restart(time_ns)


def paced(sink: Sink, rate: float, stopped: Callable[[], bool]) -> Sink:
    """Return a sink that lets each control step's messages through no sooner than it is time for them.

    Time is kept from the first state that it is given, whenever that is.
    """
    pace = Pace(rate)
    has_begun = False

    def let_through(message: Message) -> None:
        nonlocal has_begun
        if isinstance(message, State):
            if not has_begun:
                pace.restart(message.time_ns)
                has_begun = True
            pace.wait_for(message.time_ns, stopped)
        sink(message)

    return let_through


class Watch(Protocol):
    """A sink that shows people the flight whose messages it is given."""

    flight: FlightSummaryBuilder

    def __call__(self, message: Message) -> None:
        """Take one message."""

    def restart(self) -> None:
        """Forget the flight; its messages follow again."""

    def say(self, status: str) -> None:
        """Put a word about the view itself beside what it shows, where there is room for one."""


@contextmanager
def watch(title: str, waypoints: Iterable[PlannedWaypoint], setting: MissionSetting) -> Iterator[Watch]:
    """Yield what shows a flight on stderr: the live view on a terminal, a line for each event elsewhere.

    Args:
        title: of the flight.
        waypoints: of its mission.
        setting: what else the mission has fixed beforehand.
    """
    people = console(stderr=True)
    if not is_live(people):
        yield PlainLines(waypoints, setting)
        return

    with LiveView(people, title, waypoints, setting) as view:
        yield view


class PlainLines:
    """Writes one line to stderr for each happening.

    Attributes:
        flight: the flight so far.
    """

    def __init__(self, waypoints: Iterable[PlannedWaypoint], setting: MissionSetting) -> None:
        """Begin with the waypoints of the mission, and what else it has fixed beforehand."""
        self._waypoints, self._setting = tuple(waypoints), setting
        self.restart()

    def __call__(self, message: Message) -> None:
        """Take one message."""
        self.flight(message)
        event = happening(message)
        if event is not None:
            print(event.line, file=sys.stderr, flush=True)

    def restart(self) -> None:
        """Forget the flight; its messages follow again."""
        self.flight = FlightSummaryBuilder(self._waypoints, self._setting)

    def say(self, status: str) -> None:
        """Say nothing: among the lines of a flight it would be out of place."""


_STEP_NS: Final = NS_PER_S // 10
_FASTEST: Final = 1024.0
_SLOWEST: Final = 1 / 1024


@dataclass(frozen=True, slots=True)
class Playback:
    """How a flight is to be shown."""

    rate: float = 1.0  # simulated seconds in a second
    start_offset_s: float = 0.0  # from where on, from mission start
    loop: bool = False  # over and over
    start_paused: bool = False  # until the space bar is pressed


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
