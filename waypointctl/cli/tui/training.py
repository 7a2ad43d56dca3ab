"""A training on stderr: one panel on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final, Self

from rich.box import ASCII, ROUNDED
from rich.console import Console, RenderableType
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

from waypointctl.cli.console import console, is_live
from waypointctl.cli.tui.terminal import Screen
from waypointctl.cli.tui.training_text import count, duration, line, percent, rates, row, schedules, sparkline
from waypointctl.display_text import printable
from waypointctl.training.events import ENOUGH, EvaluationProgress, TrainingEvent, TrainingStatus
from waypointctl.training.recipe import Recipe

LINE_PERIOD_S: Final = 10.0  # between two lines where there is no terminal
PANEL_PERIOD_S: Final = 0.2  # between two panels where there is one
_WIDEST: Final = 100  # columns of the panel
_LABELS: Final = 12  # columns of the labels, with their gap
_FRAME: Final = 6  # columns of the frame, with the gaps inside it


@contextmanager
def training_view(
    recipe: Recipe, title: str, interrupted: Callable[[], bool]
) -> Iterator[Callable[[TrainingEvent], None]]:
    """Yield what shows a training on stderr, under a title; `interrupted` returns whether its end was requested."""
    stderr = console(stderr=True)
    if not is_live(stderr):
        yield PlainLines(recipe)
        return
    with LivePanel(stderr, recipe, title, interrupted) as panel:
        yield panel


class PlainLines:
    """Writes a line to stderr each ten seconds, for each checkpoint, and for each case of the evaluation."""

    def __init__(self, recipe: Recipe) -> None:
        """Begin."""
        self._phases = len(recipe.phases)
        self._next_s = 0.0
        self._unwritten: TrainingStatus | None = None
        self._evaluating = False

    def __call__(self, event: TrainingEvent) -> None:
        """Take an event."""
        match event:
            case TrainingStatus():
                self._unwritten = event
                if time.monotonic() >= self._next_s:
                    self._write_last()
            case EvaluationProgress(final=False):
                pass
            case EvaluationProgress():
                self._evaluation(event)
            case _:
                self._write_last()
                self._write(line(event, self._phases))

    def _evaluation(self, event: EvaluationProgress) -> None:
        if not self._evaluating:
            self._evaluating = True
            self._write(f"evaluating on the suite {event.suite}, {event.trials} trials of each case")
        if event.ended == event.trials:
            self._write(f"evaluated {event.case}")

    def _write_last(self) -> None:
        if self._unwritten is not None:
            self._write(line(self._unwritten, self._phases))
            self._unwritten = None
            self._next_s = time.monotonic() + LINE_PERIOD_S

    def _write(self, text: str) -> None:
        print(printable(text), file=sys.stderr, flush=True)


class LivePanel(Screen):
    """Draws one panel and draws it over."""

    def __init__(self, people: Console, recipe: Recipe, title: str, interrupted: Callable[[], bool]) -> None:
        """Draw on `people`, a terminal."""
        super().__init__(people, PANEL_PERIOD_S)
        self._phases = len(recipe.phases)
        self._title = title
        self._interrupted = interrupted
        self._status: TrainingStatus | None = None
        self._texts: dict[str, str] = {}  # by the label of their row
        self._history: list[tuple[float, float]] = []

    def __call__(self, event: TrainingEvent) -> None:
        """Take an event."""
        if isinstance(event, TrainingStatus):
            self._status = event
            if event.success_rate is not None:
                self._history.append((event.steps / event.total_steps, event.success_rate))
        else:
            label, text = row(event)
            self._texts[label] = text
        self.draw_if_due()

    def __enter__(self) -> Self:
        """Begin to draw."""
        super().__enter__()
        self.draw()
        return self

    def picture(self) -> Panel:
        """Return the panel, made to the terminal's width as it is now."""
        width = min(self._console.width, _WIDEST)
        columns = max(width - _LABELS - _FRAME, 1)
        table = Table.grid(padding=(0, 2, 0, 0), pad_edge=False)
        table.add_column(style="dim", no_wrap=True, overflow="crop", width=_LABELS - 2)
        table.add_column(no_wrap=True, overflow="crop" if self._ascii_only else "ellipsis", width=columns)
        for label, value in (*self._text_rows("resume", "threads"), *self._rows(columns)):
            table.add_row(label, value)
        hint = "stopping after this update" if self._interrupted() else "Ctrl-C stops it with a checkpoint"
        box = ASCII if self._ascii_only else ROUNDED
        return Panel(table, title=Text(self._title), subtitle=Text(hint), box=box, width=width, title_align="left")

    def _rows(self, columns: int) -> list[tuple[str, RenderableType]]:

        status = self._status
        if status is None:
            return [*(self._text_rows("evaluation") or [("", "making the robots")])]
        share = status.steps / status.total_steps
        return [
            ("", ProgressBar(status.total_steps, status.steps, width=columns)),
            ("steps", f"{count(status.steps)} of {count(status.total_steps)}, {share:.1%}"),
            ("speed", f"{count(status.steps_per_s)} steps/s"),
            ("time", f"{duration(status.elapsed_s)} elapsed, {duration(status.remaining_s)} left"),
            ("phase", f"{status.phase + 1} of {self._phases}, {schedules(status)}"),
            ("reward", f"{status.mean_reward:.3f} a step"),
            ("episodes", self._episodes(status)),
            ("success", sparkline(self._history, columns, ascii_only=self._ascii_only)),
            *(self._text_rows("checkpoint") or [("checkpoint", "none yet")]),
            *self._text_rows("selection", "warm start", "evaluation"),
        ]

    def _text_rows(self, *labels: str) -> list[tuple[str, RenderableType]]:
        return [(label, self._texts[label]) for label in labels if label in self._texts]

    def _episodes(self, status: TrainingStatus) -> str:
        if status.episodes < ENOUGH:
            return f"{status.episodes} so far; rates are shown from {ENOUGH} on"
        return f"{', '.join(f'{percent(rate)} {name}' for name, rate in rates(status))} of the last {status.episodes}"
