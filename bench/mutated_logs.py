"""What becomes of logs mutated at random: no traceback, bounded time and memory, no false proof.

Run: python bench/mutated_logs.py [--count 10000] [--seed 1] [--first 0]

Short flights are logged; each case is one of their logs, mutated (tests/log/mutations.py). `info` and `replay --verify`
are run on it, and on every fifth, cut short, `run --resume`, in one process. A fault is an exception that nobody
catches, an exit code other than 0, 1 and 2, more than 10 s of CPU time, or more than 1 GiB of memory. So is the verdict
EXACT, and a flight that `--resume` brings to its end, where the mcap library's readers give another state, action,
command or telemetry frame than the flight had. A new process begins with every 500th case, and where one takes longer
than a minute.
"""

from __future__ import annotations

import argparse
import io
import json
import multiprocessing
import os
import sys
import tempfile
import time
import traceback
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Final

import numpy as np
import typer
from mcap.reader import NonSeekingReader, SeekingReader

from tests.log.mutations import mutated
from waypointctl.cli.main import main as waypointctl
from waypointctl.flight.fly import fly
from waypointctl.mission.files import MissionFile, parse_mission
from waypointctl.policy.write import write_bundle

MOST_CPU_S: Final = 10.0
MOST_BYTES: Final = 2**30
MOST_WALL_S: Final = 60.0
BATCH: Final = 500
JUDGED: Final = ("/state", "/action", "/command", "/telemetry")
MISSIONS: Final = (
    "name: here\npolicy: policy\nseed: 4\nwaypoints:\n"
    "  - {name: here, position: [0 m, 0 m], tolerance: 3 m, hold: 200 ms}\n"
    "  - {name: far, position: [50 m, 0 m], timeout: 300 ms}\n",
    "name: link\npolicy: policy\nseed: 5\nautonomy: waypoint\non_failure: skip\nwaypoints:\n"
    "  - {name: here, position: [0.2 m, 0 m], tolerance: 10 m, hold: 100 ms}\n"
    "  - {name: there, position: [0 m, 0.2 m], tolerance: 10 m}\n"
    "link:\n  up: {delay: 130 ms, jitter: 20 ms}\n  down: {delay: 90 ms, jitter: 60 ms}\n",
)

Flight = dict[str, list[tuple[object, ...]]]  # what mcap's readers give of the judged topics


@dataclass(frozen=True)
class Case:
    """What became of one mutated log."""

    index: int
    done: str  # the mutations
    outcomes: tuple[str, ...]  # of the commands
    faults: tuple[str, ...]
    cpu_s: float
    peak_bytes: int


def base_logs(folder: Path) -> list[bytes]:
    """Fly the missions with a small network, and return their logs."""
    from tests.conftest import describe, random_network  # here, because the processes that try need nothing of it

    network = random_network((31, 8, 8, 8), 7)
    policy = write_bundle(folder / "policy", describe(), network.to_onnx(), network.to_safetensors())
    logs = []
    for number, text in enumerate(MISSIONS):
        mission = MissionFile(parse_mission(text.encode(), "mission.yaml"), text.encode(), folder / "mission.yaml")
        path = folder / f"base-{number}.mcap"
        fly(mission, policy, log=path)
        logs.append(path.read_bytes())
    return logs


def flight_of(file: bytes, *, seeking: bool) -> Flight:
    """Read a log with one of mcap's readers."""
    reader = (SeekingReader if seeking else NonSeekingReader)(io.BytesIO(file))
    flight: Flight = {topic: [] for topic in JUDGED}
    for schema, channel, it in reader.iter_messages(JUDGED):
        described = None if schema is None else (schema.name, schema.data)
        flight[channel.topic].append((described, it.sequence, it.log_time, it.publish_time, it.data))
    return flight


class Judge:
    """Knows the flights, and tells whether a file shows one of them to every reader."""

    def __init__(self, bases: list[bytes]) -> None:
        """Read the logs of the flights."""
        self._flights = [flight_of(base, seeking=False) for base in bases]

    def fault(self, file: bytes) -> str:
        """Return what is wrong with a file that has been proved; empty if nothing is."""
        try:
            shown = [flight_of(file, seeking=seeking) for seeking in (False, True)]
        except Exception as error:
            return f"proved, and mcap's reader fails: {error!r}"
        if shown[0] in self._flights and shown[0] == shown[1]:
            return ""
        return "proved, and its states, actions, commands or telemetry are not those of the flight"


def run(*arguments: str) -> tuple[int, str, str]:
    """Run waypointctl in this process; return exit code, stdout, and what went wrong."""
    sys.argv = ["waypointctl", *arguments]
    out, err = io.StringIO(), io.StringIO()
    try:
        with redirect_stdout(out), redirect_stderr(err):
            waypointctl()
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
        return code, out.getvalue(), "" if code in (0, 1, 2) else f"exit code {code}"
    except BaseException:
        return 3, out.getvalue(), traceback.format_exc(limit=-3)
    return 0, out.getvalue(), ""


def tried(index: int, seed: int, bases: list[bytes], judge: Judge, folder: Path) -> Case:
    """Mutate a log and run the commands on it."""
    rng = np.random.default_rng([seed, index])
    done, file = mutated(bases, rng)
    path = folder / "mutated.mcap"
    path.write_bytes(file)
    Path("/proc/self/clear_refs").write_text("5")  # the peak of memory begins anew
    began_s = time.process_time()
    outcomes, faults = [], []
    commands = [("info", "--json", str(path)), ("replay", "--verify", "--json", str(path))]
    if index % 5 == 0:
        part = folder / "cut.mcap.part"
        part.write_bytes(file[: int(len(file) * (1 - 0.4 * rng.random()))])  # before it are mostly attachments
        commands.append(("run", "--json", "--resume", str(part)))
    for command in commands:
        code, out, fault = run(*command)
        verdict = ""
        if command[0] == "replay" and code != 2 and not fault:
            verdict = json.loads(out)["verdict"]
            if verdict == "exact":
                fault = judge.fault(file)
        finished = folder / "cut.mcap"
        if command[0] == "run" and finished.exists():
            fault = fault or judge.fault(finished.read_bytes())
        outcomes.append(f"{command[0]} {verdict or code}")
        faults += [f"{command[0]}: {fault}"] if fault else []
    cpu_s = time.process_time() - began_s
    status = Path("/proc/self/status").read_text()
    peak = 1024 * int(next(line.split()[1] for line in status.splitlines() if line.startswith("VmHWM")))
    if cpu_s > MOST_CPU_S:
        faults.append(f"took {cpu_s:.1f} s")
    if peak > MOST_BYTES:
        faults.append(f"took {peak / 2**20:.0f} MiB")
    for left in folder.glob("cut.mcap*"):
        left.unlink()
    return Case(index, done, tuple(outcomes), tuple(faults), cpu_s, peak)


def work(connection: Connection, first: int, last: int, seed: int, bases: list[bytes]) -> None:
    """Try cases one after the other, and hand on what became of each."""
    with open(os.devnull, "w") as nowhere:
        for stream in (1, 2):
            os.dup2(nowhere.fileno(), stream)
    typer.main.get_command = cache(typer.main.get_command)  # takes longer than most of the cases
    judge = Judge(bases)
    with tempfile.TemporaryDirectory() as folder:
        for index in range(first, last):
            connection.send(tried(index, seed, bases, judge, Path(folder)))


def cases(first: int, last: int, seed: int, bases: list[bytes]) -> list[Case]:
    """Try a batch in a process of its own; a case that it does not come back from is a fault."""
    found: list[Case] = []
    while first < last:
        ours, theirs = multiprocessing.Pipe(duplex=False)
        process = multiprocessing.get_context("spawn").Process(target=work, args=(theirs, first, last, seed, bases))
        process.start()
        theirs.close()
        try:
            while first < last:
                if not ours.poll(MOST_WALL_S):
                    raise TimeoutError
                found.append(ours.recv())
                first = found[-1].index + 1
        except (EOFError, TimeoutError) as error:
            process.kill()
            fault = "died" if isinstance(error, EOFError) else f"took longer than {MOST_WALL_S:.0f} s"
            found.append(Case(first, "", (), (f"the process {fault}",), 0.0, 0))
            first += 1
        process.join()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    outcomes: Counter[str] = Counter()
    faults, slowest, largest = 0, 0.0, 0
    end = options.first + options.count
    with tempfile.TemporaryDirectory() as folder:
        bases = base_logs(Path(folder))
    for first in range(options.first, end, BATCH):
        for case in cases(first, min(first + BATCH, end), options.seed, bases):
            outcomes.update(case.outcomes)
            faults += bool(case.faults)
            slowest, largest = max(slowest, case.cpu_s), max(largest, case.peak_bytes)
            for fault in case.faults:
                print(f"case {case.index} ({case.done}): {fault}", flush=True)
        print(f"{first + BATCH - options.first} done", file=sys.stderr, flush=True)
    for outcome, count in sorted(outcomes.items()):
        print(f"{count:6}  {outcome}")
    print(
        f"{options.count} logs, seed {options.seed}: {faults} with a fault; at most {slowest:.1f} s of CPU time and "
        f"{largest / 2**20:.0f} MiB a log"
    )
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
