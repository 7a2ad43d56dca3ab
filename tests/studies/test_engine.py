"""Engines: the same results from each, interruptions, and workers that are killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from waypointctl.errors import WaypointctlError
from waypointctl.studies.engine import Engine, ProcessPoolEngine, SerialEngine, engine_for

ROOT = Path(__file__).parents[2]
ENGINES = [SerialEngine(), ProcessPoolEngine(2)]


def square(case: int, interrupted: Callable[[], bool]) -> int | None:
    return None if interrupted() else case * case


def wait_for_interruption(case: int, interrupted: Callable[[], bool]) -> int | None:
    while case > 1 and not interrupted():
        time.sleep(0.01)
    return case if case <= 1 else None


class KilledAsItStarts:
    """A function whose process is killed before it has read it; larger than a pipe."""

    def __init__(self) -> None:
        self.weight = bytes(1 << 20)

    def __setstate__(self, state: dict[str, object]) -> None:
        os.kill(os.getpid(), signal.SIGKILL)

    def __call__(self, case: int, interrupted: Callable[[], bool]) -> int:
        return case


def killed_at_5(case: int, interrupted: Callable[[], bool]) -> int:
    if case == 5:
        os.kill(os.getpid(), signal.SIGKILL)
    return case


def fails(case: int, interrupted: Callable[[], bool]) -> int:
    raise ValueError(f"case {case}")


@pytest.mark.parametrize("engine", ENGINES, ids=["serial", "pool"])
def test_results_are_in_the_order_of_the_cases(engine: Engine) -> None:
    seen: dict[int, int] = {}
    cases = list(range(30))
    assert engine.map(square, cases, seen.__setitem__, lambda: False) == [case * case for case in cases]
    assert seen == {case: case * case for case in cases}
    assert engine.map(square, [], seen.__setitem__, lambda: False) == []


@pytest.mark.parametrize("engine", ENGINES, ids=["serial", "pool"])
def test_an_interruption_stops_what_is_under_way_and_keeps_what_has_ended(engine: Engine) -> None:
    seen: list[int] = []
    result = engine.map(
        wait_for_interruption, [0, 1, 2, 3, 4], lambda case, _: seen.append(case), lambda: len(seen) > 1
    )
    assert result is None
    assert sorted(seen) == [0, 1]


@pytest.mark.parametrize("engine", ENGINES, ids=["serial", "pool"])
def test_an_error_of_the_function_is_raised(engine: Engine) -> None:
    with pytest.raises(ValueError, match="case 3"):
        engine.map(fails, [3], lambda case, result: None, lambda: False)


@pytest.mark.parametrize("function", [KilledAsItStarts(), killed_at_5], ids=["starting", "working"])
def test_a_worker_that_is_killed_is_an_error_and_no_hang(function: Callable[..., int]) -> None:
    with pytest.raises(WaypointctlError, match="killed"):
        ProcessPoolEngine(2).map(function, list(range(9)), lambda case, result: None, lambda: False)


# A program that was started in the background inherits that SIGINT is ignored.
SLOW_START = """
import signal
import numpy
from pathlib import Path
from tests.studies.test_engine import wait_for_interruption
from waypointctl.cli.program import interruption
from waypointctl.studies.engine import ProcessPoolEngine

if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with interruption() as interrupted:
        print(ProcessPoolEngine(2).map(wait_for_interruption, range(2, 99), lambda case, result: None, interrupted))
"""


def test_ctrl_c_while_workers_start_is_no_traceback_and_no_hang(tmp_path: Path) -> None:
    (tmp_path / "slow_start.py").write_text(SLOW_START)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, str(tmp_path / "slow_start.py")]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        workers: list[int] = []
        while not workers and running.poll() is None:
            children = Path(f"/proc/{running.pid}/task/{running.pid}/children").read_text().split()
            workers = [int(pid) for pid in children if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()]
        for pid in (*workers, running.pid):  # a terminal sends it to all of them
            os.kill(pid, signal.SIGINT)
        try:
            out, err = running.communicate(timeout=60)
        finally:
            running.kill()
    assert (running.returncode, out, err) == (0, b"None\n", b"")


def test_no_worker_outlives_the_map() -> None:
    before = set(Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split())
    ProcessPoolEngine(2).map(square, [1, 2, 3], lambda case, result: None, lambda: False)
    after = set(Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split())
    workers = [pid for pid in after - before if b"spawn_main" in Path(f"/proc/{pid}/cmdline").read_bytes()]
    assert workers == []


def test_a_few_cases_are_taken_in_this_process() -> None:
    assert isinstance(engine_for(0, 3), SerialEngine)
    assert isinstance(engine_for(1, 1000), SerialEngine)
    assert engine_for(3, 3) == ProcessPoolEngine(3)
