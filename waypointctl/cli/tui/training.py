"""Watching a training: one panel on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from types import TracebackType
from typing import TYPE_CHECKING, Final, Protocol, Self

from waypointctl.cli.console import console, is_live
from waypointctl.cli.tui.training_words import (
    count,
    done,
    lately,
    line,
    percent,
    resumed_text,
    span,
    sparkline,
    started,
    tested,
    threads_text,
)
from waypointctl.display_text import printable
from waypointctl.training.status import (
    ENOUGH,
    CheckpointSaved,
    CheckpointTested,
    CheckpointTesting,
    News,
    Resumed,
    StartedFrom,
    Threads,
    TrainingStatus,
)

if TYPE_CHECKING:
    from rich.console import Console, RenderableType
    from rich.panel import Panel

    from waypointctl.training.recipe import Recipe

LINE_PERIOD_S: Final = 10.0  # between two lines where there is no terminal
PICTURE_PERIOD_S: Final = 0.2  # between two pictures where there is one
_WIDEST: Final = 100  # columns of the panel
_LABELS: Final = 12  # columns of the labels, with their gap
_FRAME: Final = 6  # columns of the frame, with the gaps inside it


class TrainingView(AbstractContextManager["TrainingView"], Protocol):
    """Shows people how a training and its evaluation go."""

    def __call__(self, news: News) -> None:
        """Take news of the training."""

    def evaluating(self, case: str, ended: int) -> None:
        """Take news of the evaluation: how many trials of a case have ended."""


def watch_training(recipe: Recipe, title: str, interrupted: Callable[[], bool]) -> TrainingView:
    """Return what shows a training on stderr, under a title; `interrupted` says whether it has been asked to end."""
    people = console(stderr=True)
    return LivePanel(people, recipe, title, interrupted) if is_live(people) else PlainLines(recipe)


class PlainLines:
    """Writes a line to stderr each ten seconds, for each checkpoint, and for each case of the evaluation."""

    def __init__(self, recipe: Recipe) -> None:
        """Begin."""
        self._phases = len(recipe.phases)
        self._trials = recipe.evaluation.trials
        self._next_s = 0.0
        self._unsaid: TrainingStatus | None = None

    def __call__(self, news: News) -> None:
        """Take news of the training."""
        if isinstance(news, CheckpointTesting):
            return
        if isinstance(news, TrainingStatus):
            self._unsaid = news
            if time.monotonic() < self._next_s:
                return
        self._say_last()
        if not isinstance(news, TrainingStatus):
            self._say(line(news, self._phases))

    def evaluating(self, case: str, ended: int) -> None:
        """Take news of the evaluation."""
        if ended == self._trials:
            self._say(f"evaluated {case}")

    def __enter__(self) -> Self:
        """Begin."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave what has been written."""

    def _say_last(self) -> None:
        if self._unsaid is not None:
            self._say(line(self._unsaid, self._phases))
            self._unsaid = None
            self._next_s = time.monotonic() + LINE_PERIOD_S

    def _say(self, text: str) -> None:
        print(printable(text), file=sys.stderr, flush=True)


class LivePanel:
    """Draws one panel and draws it over."""

    def __init__(self, people: Console, recipe: Recipe, title: str, interrupted: Callable[[], bool]) -> None:
        """Draw on `people`, a terminal."""
        from rich.live import Live

        self._console = people
        self._recipe = recipe
        self._title = title
        self._interrupted = interrupted
        self._ascii_only = not people.encoding.lower().startswith("utf")
        self._status: TrainingStatus | None = None
        self._saved: CheckpointSaved | None = None
        self._start = self._threads = self._resumed = ""
        self._tested = ""
        self._testing = ""
        self._evaluation = ""
        self._history: list[tuple[float, float]] = []
        self._next_s = 0.0
        self._live = Live(console=people, auto_refresh=False, redirect_stdout=False, redirect_stderr=False)

    def __call__(self, news: News) -> None:
        """Take news of the training."""
        match news:
            case Threads():
                self._threads = threads_text(news)
            case Resumed():
                self._resumed = resumed_text(news)
            case StartedFrom():
                self._start = started(news)
            case CheckpointSaved():
                self._saved = news
            case CheckpointTesting():
                self._testing = f"testing {news.case}, {news.ended} of {news.trials}"
            case CheckpointTested():
                self._tested, self._testing = tested(news), ""
            case TrainingStatus():
                self._status = news
                success = dict(lately(news))["success"]
                if success is not None:
                    self._history.append((done(news), success))
        self._draw_in_time()

    def evaluating(self, case: str, ended: int) -> None:
        """Take news of the evaluation."""
        self._evaluation = f"{case}, {ended} of {self._recipe.evaluation.trials} trials"
        self._draw_in_time()

    def __enter__(self) -> Self:
        """Begin to draw."""
        self._live.start()
        self.draw()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """Leave the last picture standing."""
        self.draw()
        self._live.stop()

    def draw(self) -> None:
        """Draw now."""
        self._live.update(self.picture(), refresh=True)
        self._next_s = time.monotonic() + PICTURE_PERIOD_S

    def picture(self) -> Panel:
        """Return the panel, made to the terminal's width as it is now."""
        from rich.box import ASCII, ROUNDED
        from rich.panel import Panel
        from rich.table import Table
        from rich.text import Text

        width = min(self._console.width, _WIDEST)
        columns = max(width - _LABELS - _FRAME, 1)
        table = Table.grid(padding=(0, 2, 0, 0), pad_edge=False)
        table.add_column(style="dim", no_wrap=True, overflow="crop", width=_LABELS - 2)
        table.add_column(no_wrap=True, overflow="crop" if self._ascii_only else "ellipsis", width=columns)
        for label, value in self._rows(columns):
            table.add_row(label, value)
        hint = "stopping after this update" if self._interrupted() else "Ctrl-C stops it with a checkpoint"
        box = ASCII if self._ascii_only else ROUNDED
        return Panel(table, title=Text(self._title), subtitle=Text(hint), box=box, width=width, title_align="left")

    def _rows(self, columns: int) -> list[tuple[str, RenderableType]]:
        from rich.progress_bar import ProgressBar

        status = self._status
        ahead = [(label, value) for label, value in (("resume", self._resumed), ("threads", self._threads)) if value]
        if status is None:
            last = self._evaluation and [("evaluation", self._evaluation)]
            return [*ahead, *(last or [("", "making the robots")])]
        bar = ProgressBar(status.total_steps, status.steps, width=columns)
        rows: list[tuple[str, RenderableType]] = [
            ("", bar),
            *ahead,
            ("steps", f"{count(status.steps)} of {count(status.total_steps)}, {done(status):.1%}"),
            ("speed", f"{count(status.steps_per_s)} steps/s"),
            ("time", f"{span(status.elapsed_s)} elapsed, {span(status.remaining_s)} left"),
            ("phase", f"{status.phase + 1} of {len(self._recipe.phases)}, learning rate {status.learning_rate:.2e}"),
            ("reward", f"{status.mean_reward:.3f} a step"),
            ("episodes", self._episodes(status)),
            ("success", sparkline(self._history, columns, ascii_only=self._ascii_only)),
            ("checkpoint", "none yet" if self._saved is None else str(self._saved.folder)),
        ]
        more = (("selection", self._testing or self._tested), ("start", self._start), ("evaluation", self._evaluation))
        return [*rows, *((label, value) for label, value in more if value)]

    def _episodes(self, status: TrainingStatus) -> str:
        if status.episodes < ENOUGH:
            return f"{status.episodes} lately; rates are shown from {ENOUGH} on"
        rates = ", ".join(f"{percent(rate)} {name}" for name, rate in lately(status))
        return f"{rates} of the last {status.episodes}"

    def _draw_in_time(self) -> None:
        if time.monotonic() >= self._next_s:
            self.draw()
