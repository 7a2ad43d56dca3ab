"""How a flight under way is shown and paced, and where a person's commands come from."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from waypointctl.cli.tui.watch import Watch
    from waypointctl.flight.operator.console import LineSource
    from waypointctl.flight.sink import Sink
    from waypointctl.log.messages import Message
    from waypointctl.mission.mission import Mission


@dataclass(frozen=True, slots=True)
class FlightView:
    """What a flight is connected to.

    Attributes:
        watch: what shows it.
        sink: takes each message as it happens, no sooner than it is time for it.
        learn: takes messages that were shown before, without a word.
        console: where a person's commands come from, if there is a person.
    """

    watch: Watch
    sink: Sink
    learn: Sink
    console: LineSource | None


@contextmanager
def flight_view(
    mission: Mission, rate: float | None, interrupted: Callable[[], bool], *, console: bool
) -> Iterator[FlightView]:
    """Yield the view of a flight on stderr: live, as lines, or with a console.

    Args:
        mission: what is flown.
        rate: simulated seconds in a second; without it as fast as it goes, with a console in real time.
        interrupted: whether the end was requested.
        console: whether a person commands too.
    """
    from waypointctl.cli.tui.watch import watch
    from waypointctl.flight.header import setting_of
    from waypointctl.flight.operator.requests import planned_waypoints

    plan = planned_waypoints(mission)
    if console:
        from waypointctl.cli.console import console as people
        from waypointctl.cli.console import is_live
        from waypointctl.cli.tui.console_screen import ConsoleScreen
        from waypointctl.cli.tui.prompt import Prompt
        from waypointctl.cli.tui.terminal_input import TypedLines

        shown_on = people(stderr=True)
        typed = TypedLines(echo=is_live(shown_on))
        setting = setting_of(mission)
        screen = ConsoleScreen(shown_on, mission.name, plan, setting) if typed.is_terminal else None
        with Prompt(mission, plan, typed, rate, interrupted, screen) as prompt:
            yield FlightView(prompt, prompt, prompt.learn, prompt)
        return
    with watch(mission.name, plan, setting_of(mission)) as view:
        if rate is not None:
            view.say(f"at {rate:g} times real time")
        sink = view if rate is None else _from_first_state(view, rate, interrupted)
        yield FlightView(view, sink, lambda message: view.flight(message), None)


def _from_first_state(view: Sink, rate: float, interrupted: Callable[[], bool]) -> Sink:
    """Return a sink that keeps to `rate` from the first state that it is given, whenever that is."""
    from waypointctl.cli.tui.pace import Pace, paced
    from waypointctl.log.messages import State

    pace = Pace(rate)
    let_through = paced(view, pace, interrupted)
    has_begun = False

    def take(message: Message) -> None:
        nonlocal has_begun
        if not has_begun and isinstance(message, State):
            pace.restart(message.time_ns)
            has_begun = True
        let_through(message)

    return take
