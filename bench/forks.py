"""Run functions in forked processes, several at a time, each with a time limit, a folder and a memory limit."""

from __future__ import annotations

import contextlib
import os
import resource
import shutil
import signal
import tempfile
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, Generic, TypeVar

Key = TypeVar("Key")

_POLL_S: Final = 0.005
_MEMORY: Final = 8 << 30  # bytes, so that a loop that collects without end fails


@dataclass(frozen=True)
class Task(Generic[Key]):
    """A function to run in a process of its own: it gets an empty folder and returns the exit code."""

    key: Key
    body: Callable[[Path], int]
    limit_s: float


@dataclass(frozen=True)
class Ended(Generic[Key]):
    """What became of a task: its exit code, or None past the time limit; and what it left in `RESULT`."""

    key: Key
    code: int | None
    text: str


RESULT: Final = "result"  # the file in a task's folder


@dataclass
class _Running(Generic[Key]):
    task: Task[Key]
    folder: Path = field(default_factory=lambda: Path(tempfile.mkdtemp(prefix="mutate-")))
    begun_s: float = field(default_factory=time.monotonic)

    def start(self) -> int:
        child = os.fork()
        if child:
            return child
        os.setsid()
        resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY, _MEMORY))
        nothing = os.open(os.devnull, os.O_RDWR)
        for stream in range(3):
            os.dup2(nothing, stream)
        os.environ["PYTEST_DEBUG_TEMPROOT"] = str(self.folder)
        code = 1
        try:
            code = self.task.body(self.folder)
        except BaseException:
            (self.folder / RESULT).write_text(traceback.format_exc())
        os._exit(code)

    def end(self, child: int, code: int | None) -> Ended[Key]:
        """Take away what is left of the process, which ended with an exit code or is still running (None)."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)  # and what it started
        if code is None:
            os.waitpid(child, 0)
        result = self.folder / RESULT
        text = result.read_text() if result.exists() else ""
        shutil.rmtree(self.folder, ignore_errors=True)
        return Ended(self.task.key, code, text)


def run_all(tasks: Iterable[Task[Key]], jobs: int) -> Iterator[Ended[Key]]:
    """Run tasks, `jobs` at a time, and yield each as it ends; those still running when the caller stops are ended."""
    waiting, running = iter(tasks), dict[int, _Running[Key]]()
    try:
        while True:
            while len(running) < jobs and (task := next(waiting, None)) is not None:
                started = _Running(task)
                running[started.start()] = started
            if not running:
                return
            time.sleep(_POLL_S)
            for child, its in list(running.items()):
                done, status = os.waitpid(child, os.WNOHANG)
                if done:
                    yield running.pop(child).end(child, os.waitstatus_to_exitcode(status))
                elif time.monotonic() > its.begun_s + its.task.limit_s:
                    yield running.pop(child).end(child, None)
    finally:
        for child, its in running.items():
            its.end(child, None)
