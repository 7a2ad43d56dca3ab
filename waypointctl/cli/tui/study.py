"""How far a study is: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from waypointctl.studies.run import Progress

_LINES: Final = 10  # of a whole study, where nothing can be drawn over


@contextmanager
def study_progress() -> Iterator[Callable[[Progress], None]]:
    """Yield a function that shows on stderr how far a study is."""
    from waypointctl.cli.console import console, is_live

    people = console(stderr=True)
    if not is_live(people):
        yield _by_lines(people.print)
        return
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
    from rich.progress import Progress as Bars

    columns = (BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("{task.description}"))
    with Bars(*columns, console=people, transient=True) as bars:
        task = bars.add_task("")

        def show(progress: Progress) -> None:
            bars.update(task, completed=progress.flown, total=progress.total, description=_words(progress))

        yield show


def _by_lines(say: Callable[[str], None]) -> Callable[[Progress], None]:
    told = -1

    def show(progress: Progress) -> None:
        nonlocal told
        tenth = progress.flown * _LINES // max(progress.total, 1)
        if tenth > told:
            told = tenth
            say(f"{progress.flown} of {progress.total} flights")

    return show


def _words(progress: Progress) -> str:
    case = progress.last
    return "" if case is None else f"{case.route} {case.autonomy} {case.rtt_s:g} s"
