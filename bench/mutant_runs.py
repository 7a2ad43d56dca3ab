"""Run a part's tests against its mutants: one process collects the tests once, and each mutant is a fork of it.

A fork puts the mutant's code into the functions that are loaded and runs the tests that run the changed statement,
fastest first, until one fails. Which tests those are is measured before, each test in a fork of its own. What a mutant
changes while its module is loaded is in no function: such a mutant is run by a process that loads everything anew.
"""

from __future__ import annotations

import gc
import json
import math
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from types import CodeType, FrameType, FunctionType
from typing import Any, Final

import pytest

from bench.forks import RESULT, Ended, Task, run_all
from bench.mutants import ROOT, Mutant, MutantFinder, functions_in, mutated

_PYTEST: Final = ("-q", "-s", "-m", "not slow", "--assert=plain", "-p", "no:cacheprovider", "-p", "no:xdist")
_LONGEST_S: Final = 900.0  # of wall time, for all of the tests, also on a busy machine
_NOT_LOADED: Final = 3  # exit code: no function that is loaded has the change

Items = dict[str, pytest.Item]
Outcome = tuple[Mutant, str, str]  # the mutant; "survived", "killed" or "timeout"; the test that failed, or a reason


@dataclass(frozen=True)
class Measured:
    """A test that was run alone.

    Attributes:
        seconds: processor time that it took, whatever else the machine does.
        lines: that it ran, of each module of the part.
    """

    seconds: float
    lines: dict[str, list[int]]


_NOTHING: Final[Mapping[str, Measured]] = {}


def collected(files: Sequence[str], work: Callable[[Items], None]) -> int:
    """Let pytest collect tests, do the work in place of its loop over them, and return its exit code."""

    class Plugin:
        def pytest_runtestloop(self, session: pytest.Session) -> bool:
            if session.testsfailed:
                raise session.Interrupted("a file of tests cannot be loaded")
            work({item.nodeid: item for item in session.items})
            return True

    return int(pytest.main([*_PYTEST, *files], plugins=[Plugin()]))


def _run(items: Sequence[pytest.Item], folder: Path, measured: Mapping[str, Measured] = _NOTHING) -> int:
    """Run tests; end the process at the first that fails, with its name as the result, or that takes far too long."""

    class Plugin:
        def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
            if report.failed:
                (folder / RESULT).write_text(report.nodeid)
                os._exit(1)

    items[0].config.pluginmanager.register(Plugin())
    for item, following in zip(items, [*items[1:], None], strict=True):
        if item.nodeid in measured:
            signal.setitimer(signal.ITIMER_PROF, _limit_s(measured, [item.nodeid]))
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
    signal.setitimer(signal.ITIMER_PROF, 0)
    return 0


def in_order(measured: dict[str, Measured], mutant: Mutant | None = None) -> list[str]:
    """Return the tests that run a mutant's statement, or all: the fast ones first, those of one file together."""

    def noticing(its: Measured) -> bool:
        return mutant is None or not mutant.lines.isdisjoint(its.lines.get(mutant.path, ()))

    def rank(test: str) -> tuple[int, str, float]:
        return math.frexp(measured[test].seconds)[1], test.partition("::")[0], measured[test].seconds

    return sorted((test for test, its in measured.items() if noticing(its)), key=rank)


def _limit_s(measured: Mapping[str, Measured], tests: Iterable[str]) -> float:
    """Return how much processor time tests may take before what they do never ends."""
    return 3 + 5 * sum(measured[test].seconds for test in tests)


class Trace:
    """Records which lines of some modules are run, from `start` to `stop`."""

    def __init__(self, modules: Iterable[str]) -> None:
        """Record nothing yet; modules are paths in the repository."""
        self._paths = {str(ROOT / module): module for module in modules}
        self._ran: dict[str, set[int]] = {}

    def start(self) -> None:
        """Trace what is called from now on, in every thread that begins."""
        threading.settrace(self._on_call)
        sys.settrace(self._on_call)

    def stop(self) -> dict[str, list[int]]:
        """Return the lines that were run of each module."""
        sys.settrace(None)
        threading.settrace(None)
        return {module: sorted(lines) for module, lines in self._ran.items()}

    def _on_call(self, frame: FrameType, event: str, _: Any) -> Any:
        module = self._paths.get(frame.f_code.co_filename)
        if module is None:
            return None
        ran = self._ran.setdefault(module, set())

        def on_line(frame: FrameType, event: str, _: Any) -> Any:
            if event == "line":
                ran.add(frame.f_lineno)
            return on_line

        return on_line


def _measurement(item: pytest.Item, modules: Sequence[str]) -> Callable[[Path], int]:
    """Return a task that runs one test and results in what is measured of it."""

    def body(folder: Path) -> int:
        trace, begun_s = Trace(modules), time.process_time()
        trace.start()
        code = _run([item], folder)
        its = Measured(time.process_time() - begun_s, trace.stop())
        (folder / RESULT).write_text(json.dumps(asdict(its)))
        return code

    return body


def measure(items: Items, modules: Sequence[str], jobs: int) -> dict[str, Measured]:
    """Measure every test in a fork of its own; leave out those that fail alone or, in our order, after others."""
    measured: dict[str, Measured] = {}
    tasks = (Task(test, _measurement(item, modules), _LONGEST_S) for test, item in items.items())
    for ended in run_all(tasks, jobs):
        if ended.code == 0:
            measured[ended.key] = Measured(**json.loads(ended.text))
        else:
            print(f"left out, fails alone: {ended.key}", file=sys.stderr)
    while measured:
        tests = in_order(measured)
        everything = partial(_run, [items[test] for test in tests])
        (ended,) = run_all([Task("", everything, _LONGEST_S)], 1)
        if ended.code == 0:
            break
        print(f"left out, fails after others: {ended.text}", file=sys.stderr)
        del measured[ended.text]
    return measured


def run_in_place(
    mutants: Sequence[Mutant], items: Items, measured: dict[str, Measured], jobs: int
) -> Iterator[Outcome]:
    """Run mutants by changing loaded functions; yield what becomes of each that is in one."""
    paths = {str(ROOT / mutant.path) for mutant in mutants}
    functions = [it for it in gc.get_objects() if type(it) is FunctionType and it.__code__.co_filename in paths]
    gc.freeze()

    def task(mutant: Mutant) -> Task[Mutant]:
        code, tests = mutated(mutant), in_order(measured, mutant)

        def body(folder: Path) -> int:
            if not _swap(functions, code):
                return _NOT_LOADED
            if not tests:
                (folder / RESULT).write_text("no test runs it")
                return 0
            return _run([items[test] for test in tests], folder, measured)

        return Task(mutant, body, _LONGEST_S)

    for ended in run_all(map(task, mutants), jobs):
        if ended.code != _NOT_LOADED:
            yield _outcome(ended)


def _swap(functions: Sequence[FunctionType], module: CodeType) -> bool:
    """Give loaded functions a module's new code, and return whether one of them has changed."""
    new = {(code.co_filename, code.co_qualname, code.co_firstlineno): code for code in functions_in(module)}
    changed = False
    for function in functions:
        old = function.__code__
        code = new.get((old.co_filename, old.co_qualname, old.co_firstlineno), old)
        if code != old:
            if len(code.co_freevars) != len(old.co_freevars):
                return False
            function.__code__ = code
            changed = True
    return changed


def run_anew(
    mutants: Iterable[Mutant], files: Sequence[str], measured: dict[str, Measured], jobs: int
) -> Iterator[Outcome]:
    """Run mutants of what is done when a module is loaded; nothing of waypointctl may be loaded yet."""
    tests = in_order(measured)

    def task(mutant: Mutant) -> Task[Mutant]:
        finder = MutantFinder(mutant.path, mutated(mutant))

        def body(folder: Path) -> int:
            sys.meta_path.insert(0, finder)
            return collected(files, lambda items: _run_those(items, tests, folder, measured))

        return Task(mutant, body, _LONGEST_S)

    return map(_outcome, run_all(map(task, mutants), jobs))


def _run_those(items: Items, tests: Sequence[str], folder: Path, measured: Mapping[str, Measured]) -> None:
    _run([items[test] for test in tests], folder, measured)


def _outcome(ended: Ended[Mutant]) -> Outcome:
    too_long = ended.code in (None, -signal.SIGPROF)
    what = "timeout" if too_long else "survived" if ended.code == 0 else "killed"
    return ended.key, what, ended.text
