"""How many flights have ended: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, TypeAlias

Show: TypeAlias = Callable[[int, int], None]  # called with the number of flights that have ended, and of all

_LINES: Final = 10  # in all, where nothing can be drawn over


@contextmanager
def flights_progress() -> Iterator[Show]:
    """Yield a function that shows on stderr how many flights have ended."""
    from waypointctl.cli.console import console, is_live

    people = console(stderr=True)
    if not is_live(people):
        yield _by_lines(people.print)
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    with Progress(BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), console=people, transient=True) as bars:
        task = bars.add_task("")
        yield lambda ended, total: bars.update(task, completed=ended, total=total)


def _by_lines(say: Callable[[str], None]) -> Show:
    printed = -1

    def show(ended: int, total: int) -> None:
        nonlocal printed
        tenth = ended * _LINES // max(total, 1)
        if tenth > printed:
            printed = tenth
            say(f"{ended} of {total} flight{'s' * (total != 1)}")

    return show
