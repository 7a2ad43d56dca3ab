"""Engines: what maps a function over many cases, with progress and interruption.

The results are those of `[function(case) for case in cases]`, whatever the engine and the number of processes.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing.reduction import DupFd
from multiprocessing.synchronize import Event
from typing import Any, Final, Protocol, TypeAlias, TypeVar

from waypointctl.errors import WaypointctlError

C = TypeVar("C")
R = TypeVar("R")

Interrupted: TypeAlias = Callable[[], bool]
# Picklable, and pure: its result depends on the case alone. It returns None if it stopped because of an interruption.
Function: TypeAlias = Callable[[C, Interrupted], R | None]
Progress: TypeAlias = Callable[[C, R], None]

_WAIT_S: Final = 0.2  # how soon an interruption is noticed
_FEW_CASES: Final = 4  # for each process; starting it takes longer than flying them


class Engine(Protocol):
    """What maps a function over cases."""

    def map(
        self, function: Function[C, R], cases: Sequence[C], progress: Progress[C, R], interrupted: Interrupted
    ) -> list[R] | None:
        """Return the results in the order of the cases; None if it was interrupted.

        Args:
            function: maps a case to its result.
            cases: picklable.
            progress: called in this process with each case and its result, in the order in which they end.
            interrupted: whether to stop; called again and again. What has been passed to `progress` is complete.

        Raises:
            WaypointctlError: a process was killed.
        """
        ...


class SerialEngine:
    """Takes one case after the other, in this process."""

    def map(
        self, function: Function[C, R], cases: Sequence[C], progress: Progress[C, R], interrupted: Interrupted
    ) -> list[R] | None:
        """Return the results in the order of the cases; see Engine."""
        results = []
        for case in cases:
            result = None if interrupted() else function(case, interrupted)
            if result is None:
                return None
            progress(case, result)
            results.append(result)
        return results


@dataclass(frozen=True, slots=True)
class ProcessPoolEngine:
    """Takes several cases at a time, in processes of its own."""

    processes: int

    def map(
        self, function: Function[C, R], cases: Sequence[C], progress: Progress[C, R], interrupted: Interrupted
    ) -> list[R] | None:
        """Return the results in the order of the cases; see Engine."""
        context = multiprocessing.get_context("spawn")  # forked, onnxruntime's and mujoco's threads would be missing
        stop, results = context.Event(), dict[int, R]()
        to_do, running = iter(enumerate(cases)), dict[Future[R | None], int]()

        def take(done: set[Future[R | None]]) -> None:
            for future in done:
                at, result = running.pop(future), future.result()
                if result is not None:
                    results[at] = result
                    progress(cases[at], result)

        with (
            _pickled(function) as given,
            ProcessPoolExecutor(self.processes, context, _begin_process, (given, stop)) as executor,
        ):
            try:
                while len(results) < len(cases) and not interrupted():
                    with _sigint_blocked():  # submitting starts the processes
                        while len(running) < 2 * self.processes and (next_case := next(to_do, None)) is not None:
                            running[executor.submit(_call, next_case[1])] = next_case[0]
                    take(wait(running, _WAIT_S, FIRST_COMPLETED).done)
                take({future for future in running if future.done()})
            except BrokenProcessPool as error:
                for process in multiprocessing.active_children():
                    process.terminate()  # the executor waits for one that it was starting when it ended the others
                if not interrupted():
                    raise WaypointctlError("a worker process was killed") from error
            finally:
                stop.set()
        return [results[at] for at in range(len(cases))] if len(results) == len(cases) else None


def engine_for(processes: int, cases: int) -> Engine:
    """Return the engine for a number of processes, 0 for one a core; a few cases are taken in this process."""
    if not processes:
        processes = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        processes = min(processes, cases // _FEW_CASES)
    return SerialEngine() if processes <= 1 else ProcessPoolEngine(processes)


class _OpenFile:
    """A pickle in an open file, which a process that starts is given.

    What a process is given at its start goes through a pipe. If the process is killed before it has read the pipe, a
    parent that writes more than the pipe holds waits forever. A function with its policy can be larger than a pipe.
    """

    def __init__(self, fd: int) -> None:
        """Take the descriptor of the file."""
        self._fd = fd

    def __reduce__(self) -> tuple[Callable[[Any], _OpenFile], tuple[Any]]:
        """Hand the open file over."""
        return _inherited, (DupFd(self._fd),)

    def load(self) -> Any:
        """Return what was pickled; the position in the file, which is common to all processes, stays."""
        return pickle.loads(os.pread(self._fd, os.fstat(self._fd).st_size, 0))


@contextmanager
def _pickled(function: Any) -> Iterator[_OpenFile]:
    with tempfile.TemporaryFile() as file:  # it has no name, so that nothing stays of it, however this process ends
        pickle.dump(function, file)
        file.flush()
        yield _OpenFile(file.fileno())


def _inherited(shared: Any) -> _OpenFile:
    return _OpenFile(shared.detach())


@contextmanager
def _sigint_blocked() -> Iterator[None]:
    """Hold Ctrl-C back in a `with` block; processes that are started in it never get it, also while they import."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


_function: Function[Any, Any]
_stop: Event


def _begin_process(file: _OpenFile, stop: Event) -> None:
    """Make this process a worker; its parent, which has Ctrl-C, sets the event that ends it."""
    global _function, _stop
    _function, _stop = file.load(), stop


def _call(case: Any) -> Any:
    return None if _stop.is_set() else _function(case, _stop.is_set)
