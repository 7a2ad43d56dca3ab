"""Flying the cases of a study: one after the other, or several at a time in processes of their own."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import tempfile
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing.reduction import DupFd
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any, Final

from waypointctl.errors import WaypointctlError
from waypointctl.flight.fly import fly
from waypointctl.flight.record import record
from waypointctl.mission.files import MissionFile, dump_mission
from waypointctl.policy.bundle import LoadedPolicy, load_policy_bytes
from waypointctl.robots.load import load_robot
from waypointctl.robots.robot import Robot
from waypointctl.studies.case import Case, mission_of
from waypointctl.studies.measure import Flown, Measure

_WAIT_S: Final = 0.2  # how soon an interruption is noticed


@dataclass(frozen=True, slots=True)
class Plan:
    """What all flights of a study have in common; plain data, which goes to the processes that fly.

    Attributes:
        routes: by name.
        policy_files: the bundle of who walks.
        policy_name: for messages.
        think_s: the operator's, in place of the routes' own.
        logs: the folder for the flights' logs, which is there; None for none.
    """

    routes: Mapping[str, MissionFile]
    policy_files: Mapping[str, bytes]
    policy_name: str
    think_s: float | None = None
    logs: Path | None = None


class Pilot:
    """Flies cases of a plan."""

    def __init__(self, plan: Plan) -> None:
        """Load the policy; the network computes on one thread, so that flights side by side do not get in the way."""
        self._plan = plan
        self._policy: LoadedPolicy = load_policy_bytes(plan.policy_files, plan.policy_name)
        self._robots: dict[str, Robot] = {}

    def fly(self, case: Case, interrupted: Callable[[], bool]) -> Flown | None:
        """Fly a case; return how it went, None if it was interrupted."""
        file = self._plan.routes[case.route]
        mission = mission_of(file.mission, case, self._plan.think_s)
        measure = Measure()
        if self._plan.logs is not None:
            given = replace(file, mission=mission, source=dump_mission(mission).encode())
            log = self._plan.logs / log_name(case)
            result = record(given, self._policy, log, watch=measure, interrupted=interrupted).result
        else:
            if mission.robot not in self._robots:
                self._robots[mission.robot] = load_robot(mission.robot)
            result = fly(mission, self._policy, measure, robot=self._robots[mission.robot], interrupted=interrupted)
        return None if result.outcome == "interrupted" else measure.flown(case, result)


def log_name(case: Case) -> str:
    """Return the name of the log of a case."""
    return f"{case.route}-{case.autonomy}-{case.rtt_s:g}s-{case.seed}.mcap"


def fly_cases(plan: Plan, cases: Sequence[Case], jobs: int, interrupted: Callable[[], bool]) -> Iterator[Flown]:
    """Fly cases and yield how each went, as they end; an interruption ends it, without the flights under way.

    Args:
        plan: what they have in common.
        cases: to fly.
        jobs: how many at a time; 1 flies in this process.
        interrupted: asked again and again.

    Raises:
        WaypointctlError: a process that flew was killed.
    """
    return _in_turn(plan, cases, interrupted) if jobs == 1 else _side_by_side(plan, cases, jobs, interrupted)


def _in_turn(plan: Plan, cases: Sequence[Case], interrupted: Callable[[], bool]) -> Iterator[Flown]:
    pilot = Pilot(plan)
    for case in cases:
        flown = None if interrupted() else pilot.fly(case, interrupted)
        if flown is None:
            return
        yield flown


def _side_by_side(plan: Plan, cases: Sequence[Case], jobs: int, interrupted: Callable[[], bool]) -> Iterator[Flown]:
    context = multiprocessing.get_context("spawn")  # forked, onnxruntime's and mujoco's threads would be missing
    stop = context.Event()
    to_fly, under_way = deque(cases), set[Future[Flown | None]]()
    with (
        _plan_file(plan) as given,
        ProcessPoolExecutor(jobs, context, _begin_process, (given, stop)) as executor,
    ):
        try:
            while (to_fly or under_way) and not interrupted():
                with _sigint_blocked():  # submitting starts the processes
                    while to_fly and len(under_way) < 2 * jobs:
                        under_way.add(executor.submit(_fly_in_process, to_fly.popleft()))
                done, under_way = wait(under_way, _WAIT_S, FIRST_COMPLETED)
                yield from _flown(done)
            yield from _flown([future for future in under_way if future.done()])
        except BrokenProcessPool as error:
            for process in multiprocessing.active_children():
                process.terminate()  # the executor waits for one that it was starting when it ended the others
            if not interrupted():
                raise WaypointctlError("a process that flew was killed; the same command goes on") from error
        finally:
            stop.set()


def _flown(done: Iterable[Future[Flown | None]]) -> Iterator[Flown]:
    return (flown for flown in (future.result() for future in done) if flown is not None)


class _PlanFile:
    """A plan in an open file, which a process that starts is given.

    What a process is given at its start goes through a pipe. If the process is killed before it has read the pipe, a
    parent that writes more than the pipe holds waits forever. A plan, with its policy, can be larger than a pipe.
    """

    def __init__(self, fd: int) -> None:
        """Take the descriptor of the file."""
        self._fd = fd

    def __reduce__(self) -> tuple[Callable[[Any], _PlanFile], tuple[Any]]:
        """Hand the open file over."""
        return _inherited, (DupFd(self._fd),)

    def plan(self) -> Plan:
        """Return the plan; the position in the file, which is common to all processes, stays."""
        plan: Plan = pickle.loads(os.pread(self._fd, os.fstat(self._fd).st_size, 0))
        return plan


@contextmanager
def _plan_file(plan: Plan) -> Iterator[_PlanFile]:
    with tempfile.TemporaryFile() as file:  # it has no name, so that nothing stays of it, however this process ends
        pickle.dump(plan, file)
        file.flush()
        yield _PlanFile(file.fileno())


def _inherited(shared: Any) -> _PlanFile:
    return _PlanFile(shared.detach())


@contextmanager
def _sigint_blocked() -> Iterator[None]:
    """Hold Ctrl-C back in a `with` block; processes that are started in it never get it, also while they import."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


_pilot: Pilot
_stop: Event


def _begin_process(file: _PlanFile, stop: Event) -> None:
    """Make this process one that flies; its parent, which has Ctrl-C, says when it ends."""
    global _pilot, _stop
    _pilot, _stop = Pilot(file.plan()), stop


def _fly_in_process(case: Case) -> Flown | None:
    return None if _stop.is_set() else _pilot.fly(case, _stop.is_set)
