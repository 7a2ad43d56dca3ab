"""The console of a flight: typed lines go to the operator, received messages are shown.

Only what the operator knows is shown: an event on board appears when the downlink has delivered it.
"""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from types import TracebackType
from typing import Final, Self

from waypointctl.cli.tui.formatting import happening, status_lines
from waypointctl.cli.tui.playback import Pace
from waypointctl.cli.tui.screens import SIGN, ConsoleScreen
from waypointctl.cli.tui.terminal import TypedLines
from waypointctl.display_text import printable_lines
from waypointctl.flight.header import setting_of
from waypointctl.flight.operator.console import QUIT, USAGE, impossible, request_from
from waypointctl.log.messages import Clock, Message, PlannedWaypoint
from waypointctl.mission.mission import Mission
from waypointctl.replay.summary_builder import FlightSummaryBuilder, OperatorView
from waypointctl.units import seconds

HELP: Final = f"commands: {USAGE}"
_INTRODUCTION: Final = (
    "commands travel over the link; `status` shows what the operator knows, `quit` closes the console"
)
_CLOSED: Final = "the console is closed; the flight continues to its end"


class Prompt:
    """Watches a flight, and is where its lines come from; use it in a `with` block.

    Attributes:
        flight: the flight so far, the truth of it too: it is shown when the flight is over.
        is_open: whether lines may still come: always, at mission start.
    """

    is_open = True

    def __init__(
        self,
        mission: Mission,
        waypoints: Iterable[PlannedWaypoint],
        typed: TypedLines,
        rate: float | None,
        interrupted: Callable[[], bool],
        screen: ConsoleScreen | None = None,
    ) -> None:
        """Talk on stdin and stderr. Without a `rate` time is real until the console is closed, then it flies.

        A `screen` is what a terminal shows; without one a line is written for each event.
        """
        self._mission = mission
        self._waypoints = tuple(waypoints)
        self._typed = typed
        self._keeps_pace = rate is not None
        self._pace = Pace(rate or 1.0, idle=self._listen)
        self._interrupted = interrupted
        self._screen = screen
        self._taken: deque[str] = deque()
        self._has_begun = self._has_quit = False
        self.restart()

    def __call__(self, message: Message) -> None:
        """Take one message of the flight, and print the event that the operator learns of."""
        self.learn(message)
        event = happening(message)
        if event is not None and event.clock is Clock.OPERATOR:
            self.say(event.line)
        self._draw()

    def __enter__(self) -> Self:
        """Begin to read."""
        self._typed.__enter__()
        if self._screen is not None:
            self._screen.__enter__()
        self.say(f"{HELP}\n{_INTRODUCTION}")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the terminal as it was."""
        if self._screen is not None:
            self._screen.__exit__(kind, error, traceback)
        self._typed.__exit__(kind, error, traceback)

    def restart(self) -> None:
        """Forget the flight; its messages follow again."""
        self.flight = FlightSummaryBuilder(self._waypoints, setting_of(self._mission))
        self._view = OperatorView()
        if self._screen is not None:
            self._screen.restart()

    def learn(self, message: Message) -> None:
        """Take one message without printing: it was printed before."""
        self.flight(message)
        self._view(message)
        if self._screen is not None:
            self._screen(message)

    def say(self, status: str) -> None:
        """Print lines above what is being typed."""
        if self._screen is not None:
            self._screen.say(status)
        else:
            print(printable_lines(status), file=sys.stderr, flush=True)

    def lines(self, now_ns: int) -> Iterator[str]:
        """Wait until it is time for `now_ns`; yield what has been typed for the operator to do."""
        if self._has_quit:
            self._keep_pace(now_ns)
            return
        if not self._has_begun:
            self._pace.restart(now_ns)
            self._has_begun = True
        self._pace.wait_for(now_ns, self._interrupted)
        self._listen(0.0)
        while self._taken and not self._has_quit:
            line = self._taken.popleft()
            self._has_quit = line == QUIT
            yield line

    def asleep(self, now_ns: int, until_ns: int) -> int:
        """Return when something is typed or somebody ends the flight; at the latest, and on time, `until_ns`."""
        if self._has_quit:
            return until_ns
        self._pace.wait_for(until_ns, lambda: bool(self._taken) or self._interrupted())
        return min(until_ns, max(now_ns, self._pace.now_ns)) if self._taken or self._interrupted() else until_ns

    def _keep_pace(self, now_ns: int) -> None:
        if self._keeps_pace:
            self._pace.wait_for(now_ns, self._interrupted)

    def _listen(self, timeout_s: float) -> None:
        """Take what is typed; what needs no operator is answered at once."""
        before = self._typed.draft
        lines = self._typed.read(timeout_s)
        for line in lines:
            if self._screen is not None:
                self._screen.say(f"{SIGN}{line}")
            self._answer(line)
        if not self._typed.is_open and QUIT not in self._taken and not self._has_quit:
            self._taken.append(QUIT)
        self._draw(at_once=bool(lines) or self._typed.draft != before)

    def _draw(self, *, at_once: bool = False) -> None:
        if self._screen is None:
            return
        self._screen.prompt = _CLOSED if self._has_quit else f"{SIGN}{self._typed.draft}"
        self._screen.view.pass_time(self._now_ns)
        (self._screen.draw if at_once else self._screen.draw_if_due)()

    @property
    def _now_ns(self) -> int:
        """The time on the operator's clock: the simulation is a step ahead of it, or has left it behind."""
        now_ns = self.flight.now_ns
        return now_ns if self._has_quit or not self._has_begun else max(self._pace.now_ns, now_ns)

    def _answer(self, line: str) -> None:
        now_ns = self._now_ns
        match line:
            case "":
                return
            case "help":
                self.say(HELP)
            case "time":
                self.say(f"time {seconds(now_ns):.2f} s, at {self._pace.rate:g} times real time")
            case "status":
                self.say("\n".join([f"time {seconds(now_ns):.2f} s", *status_lines(self._view, now_ns)]))
            case _:
                self._send(line)

    def _send(self, line: str) -> None:
        try:
            wrong = "" if line == QUIT else impossible(request_from(line, self._mission), self._mission)
        except ValueError as error:
            wrong = str(error)
        if wrong:
            self.say(f"not sent: {wrong}")
            return
        self._taken.append(line)
