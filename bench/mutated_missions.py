"""What becomes of missions mutated at random: an answer with its place, and no traceback, in bounded time and memory.

Run: PYTHONPATH=. python bench/mutated_missions.py [--count 10000] [--seed 1] [--first 0]

Each case is one of the shipped missions, mutated (tests/mission/mutations.py). `validate` is run on it; where it is
valid, `fmt` lays it out, it is read again, and it is flown for a second. All is done in one process; a new
one begins with every 200th case, and where one takes longer than a minute. A fault is an exception that nobody catches,
an exit code other than 0 and 2, a refusal without file, line and column (but of a file that is too large to be read), a
mission that changes when it is laid out, more than 10 s of CPU time, or more than 1 GiB of memory.
"""

from __future__ import annotations

import argparse
import io
import json
import multiprocessing
import random
import re
import shutil
import sys
import tempfile
import time
import traceback
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import asdict, dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Final

import typer

from tests.mission.mutations import mutated
from waypointctl.cli.app import app
from waypointctl.errors import InputError
from waypointctl.flight.fly import fly
from waypointctl.log.messages import State
from waypointctl.mission.files import load_mission
from waypointctl.policy.bundle import LoadedPolicy, load_policy

REPOSITORY: Final = Path(__file__).parents[1]
MOST_CPU_S: Final = 10.0
MOST_BYTES: Final = 2**30
MOST_WALL_S: Final = 60.0
BATCH: Final = 200
FLOWN_S: Final = 1.0
COMMAND: Final = typer.main.get_command(app)

_PLACE: Final = re.compile(r"^.+?:(\d+:\d+:| is larger than) ", re.MULTILINE)


@dataclass(frozen=True)
class Case:
    """What became of one mutated mission."""

    index: int
    base: str
    outcome: str
    faults: tuple[str, ...]
    cpu_s: float
    peak_bytes: int


def run(*arguments: str) -> tuple[int, str, str]:
    """Run a command in this process; return exit code, all that it printed, and what went wrong."""
    printed = io.StringIO()
    try:
        with redirect_stdout(printed), redirect_stderr(printed):
            code = COMMAND.main(list(arguments), prog_name="waypointctl", standalone_mode=False)
    except InputError as error:
        return 2, str(error), ""
    except BaseException:
        return 3, printed.getvalue(), traceback.format_exc(limit=-4)
    return code or 0, printed.getvalue(), ""


def validated(path: Path) -> tuple[int, list[str]]:
    """Run `validate`; return its exit code and the faults of its answer."""
    code, said, fault = run("validate", str(path))
    faults = [fault] if fault else []
    if code not in (0, 1, 2):
        faults.append(f"validate: exit code {code}")
    if code == 2 and not _PLACE.search(said):
        faults.append(f"validate: no place: {said[:300]!r}")
    return code, faults


def flown(path: Path, policy: LoadedPolicy, folder: Path) -> list[str]:
    """Fly the beginning of a mission; return what went wrong."""
    now_ns = 0

    def watch(message: object) -> None:
        nonlocal now_ns
        if isinstance(message, State):
            now_ns = message.time_ns

    began_s, steps = time.process_time(), 0

    def over() -> bool:
        nonlocal steps
        steps += 1
        return now_ns > FLOWN_S * 1e9 or steps > 200 or time.process_time() - began_s > 5.0

    try:
        fly(load_mission(path), policy, watch, log=folder / "log.mcap", interrupted=over)
    except InputError as error:
        return [f"validates, and cannot be flown: {error}"]
    except BaseException:
        return [traceback.format_exc(limit=-4)]
    return []


def tried(index: int, seed: int, bases: list[Path], policy: LoadedPolicy, folder: Path) -> Case:
    """Mutate a mission and try it."""
    rng = random.Random(f"{seed}-{index}")
    base = rng.choice(bases)
    path = folder / "mutated.yaml"
    path.write_bytes(mutated(base.read_bytes(), rng))
    Path("/proc/self/clear_refs").write_text("5")  # the peak of memory begins anew
    began_s = time.process_time()
    code, faults = validated(path)
    if code != 2:
        before = load_mission(path).mission
        _, _, fault = run("fmt", str(path))
        faults += [fault] if fault else []
        if load_mission(path).mission != before:
            faults.append("fmt changes the mission")
        faults += flown(path, policy, folder)
    cpu_s, peak_bytes = time.process_time() - began_s, _peak_bytes()
    if cpu_s > MOST_CPU_S:
        faults.append(f"{cpu_s:.1f} s")
    if peak_bytes > MOST_BYTES:
        faults.append(f"{peak_bytes / 2**20:.0f} MiB")
    return Case(
        index,
        base.name,
        {0: "valid", 1: "cannot succeed", 2: "refused"}.get(code, "fault"),
        tuple(faults),
        cpu_s,
        peak_bytes,
    )


def _peak_bytes() -> int:
    found = re.search(r"VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text())
    return int(found[1]) * 1024 if found else 0


def work(sending: Connection, first: int, last: int, seed: int, folder: Path) -> None:
    """Try some cases in a process of their own, and send what became of each."""
    bases = sorted((folder / "missions").glob("*.yaml"))
    policy = load_policy(folder / "policies" / "ant-waypoint")
    for index in range(first, last):
        sending.send(tried(index, seed, bases, policy, folder / "missions"))
    sending.close()


def campaign(first: int, count: int, seed: int, folder: Path) -> list[Case]:
    """Try all cases, a batch in each process; one that hangs or dies is a fault of the case that it was at."""
    for name in ("missions", "policies"):
        shutil.copytree(REPOSITORY / name, folder / name)
    cases: list[Case] = []
    index, last = first, first + count
    context = multiprocessing.get_context("spawn")
    while index < last:
        receiving, sending = context.Pipe(duplex=False)
        end = min(index + BATCH, last)
        process = context.Process(target=work, args=(sending, index, end, seed, folder))
        process.start()
        sending.close()
        while index < end:
            try:
                if not receiving.poll(MOST_WALL_S):
                    raise EOFError
                case = receiving.recv()
            except EOFError:
                case = Case(index, "", "fault", ("the process hung or died",), MOST_WALL_S, 0)
                end = index + 1
            cases.append(case)
            index += 1
            if case.faults:
                print(json.dumps(asdict(case)), flush=True)
        process.kill()
        process.join()
        print(f"{index - first} of {count}", file=sys.stderr, flush=True)
    return cases


def main() -> int:
    """Run the campaign and print what became of the cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        cases = campaign(asked.first, asked.count, asked.seed, Path(folder))
    print(f"{len(cases)} mutated missions: {dict(Counter(case.outcome for case in cases))}")
    slowest = max(cases, key=lambda case: case.cpu_s)
    print(f"slowest {slowest.cpu_s:.1f} s CPU (case {slowest.index}), most memory ", end="")
    print(f"{max(case.peak_bytes for case in cases) / 2**20:.0f} MiB")
    faults = sum(bool(case.faults) for case in cases)
    print(f"{faults} with a fault")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
