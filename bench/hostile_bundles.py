"""Hostile policies, archives, evaluations, missions' files and logs' models: each refused, or used, within bounds.

Run: python bench/hostile_bundles.py [--count 500] [--seed 0] [--only NAME] [--keep FOLDER]

Each attempt is made from the seed (tests/hostile/) and tried with the command line in a process of its own, forked from
one that has loaded the program's modules, with 8 GiB of address space. Counted are tracebacks, exit codes that are
not 0, 1 or 2 or not those that the attempt allows, more than 10 s, more than 1 GiB of memory (the process's largest
resident size, what it shares with its parent included), and what a link out of a folder leads to in the output. Times
are the process's CPU time; one that is not over after 60 s of the clock is killed.
"""

from __future__ import annotations

import argparse
import importlib
import os
import resource
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.hostile.bundles import FAMILIES, Attempt, attempts
from tests.hostile.logs import LOGS
from tests.hostile.mutation import SECRET
from tests.hostile.sound import sound_archive, sound_files, sound_log

MOST_S = 10.0
MOST_BYTES = 2**30
HANGS_S = 60.0
SPACE_BYTES = 2**33
MODULES = ("waypointctl.flight.fly", "waypointctl.replay.verify", "waypointctl.evaluation.evaluate", "onnxruntime")


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a command ended: its exit code, or the signal that ended it as a negative number."""

    code: int
    cpu_s: float
    wall_s: float
    memory_bytes: int
    output: str

    def faults(self, attempt: Attempt) -> list[str]:
        """Return what is wrong with it."""
        found = {
            "traceback": "Traceback" in self.output,
            f"exit code {self.code}": self.code not in attempt.may,
            f"{self.cpu_s:.1f} s": max(self.cpu_s, 0.0) > MOST_S or self.wall_s > HANGS_S,
            f"{self.memory_bytes >> 20} MiB": self.memory_bytes > MOST_BYTES,
            "another file's content": f"{SECRET}\n" in self.output,
            f"no {attempt.says!r}": attempt.says not in self.output,
        }
        return [name for name, is_so in found.items() if is_so]


def tried(attempt: Attempt) -> Outcome:
    """Return how an attempt's command ends in a process of its own."""
    with tempfile.TemporaryFile() as output:
        begun = time.monotonic()
        child = os.fork()
        if child == 0:
            _run(attempt, output.fileno())
        while True:
            ended, status, usage = os.wait4(child, os.WNOHANG)
            wall_s = time.monotonic() - begun
            if ended:
                break
            if wall_s > HANGS_S:
                os.kill(child, signal.SIGKILL)
            time.sleep(0.005)
        output.seek(0)
        text = output.read().decode(errors="replace")
    cpu_s = usage.ru_utime + usage.ru_stime
    return Outcome(os.waitstatus_to_exitcode(status), cpu_s, wall_s, usage.ru_maxrss * 1024, text)


def _run(attempt: Attempt, output: int) -> None:
    """Become the command; never returns."""
    from waypointctl.cli.main import main

    code = 99
    try:
        resource.setrlimit(resource.RLIMIT_AS, (SPACE_BYTES, SPACE_BYTES))
        os.chdir(attempt.folder)
        for stream in (1, 2):
            os.dup2(output, stream)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        sys.argv = ["waypointctl", *attempt.arguments]
        main()
        code = 0
    except SystemExit as ended:
        code = ended.code if isinstance(ended.code, int) else 0 if ended.code is None else 1
    except BaseException:
        import traceback

        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def campaign(made: Iterator[Attempt], chosen: str) -> Counter[str]:
    """Try attempts with a text in their names; print what is wrong with any, and return counts and maxima."""
    totals: Counter[str] = Counter()
    for attempt in made:
        if chosen not in attempt.name:
            continue
        outcome = tried(attempt)
        faults = outcome.faults(attempt)
        totals.update({"attempts": 1, f"exit code {outcome.code}": 1, "at fault": bool(faults)})
        totals["most CPU [ms]"] = max(totals["most CPU [ms]"], round(outcome.cpu_s * 1000))
        totals["most memory [MiB]"] = max(totals["most memory [MiB]"], outcome.memory_bytes >> 20)
        if faults:
            print(f"{attempt.folder}: {attempt.name}: {', '.join(faults)}\n  {' '.join(attempt.arguments)}")
            print("  " + "\n  ".join(outcome.output.splitlines()[-12:]))
    return totals


def main() -> None:
    """Try them all."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="", help="attempts with this in their name")
    parser.add_argument("--keep", type=Path, help="write the files here, and leave them")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="hostile-") as temporary:
        folder = given.keep or Path(temporary)
        share = given.count // 4
        for module in MODULES:
            importlib.import_module(module)
        sound = sound_files(folder / "sound")
        totals = campaign(
            attempts(FAMILIES, given.count - 2 * share, given.seed, folder / "bundles", sound), given.only
        )
        sound = sound_log(folder / "sound", sound)
        more = campaign(attempts(LOGS, share, given.seed, folder / "logs", sound), given.only)
        sound = sound_archive(folder / "sound", sound)
        from tests.hostile.archives import ARCHIVES

        last = campaign(attempts(ARCHIVES, share, given.seed, folder / "archives", sound), given.only)
    for name in sorted({*totals, *more, *last}):
        values = [each[name] for each in (totals, more, last)]
        print(f"{name:20} {max(values) if name.startswith('most') else sum(values):8}")
    sys.exit(1 if totals["at fault"] + more["at fault"] + last["at fault"] else 0)


if __name__ == "__main__":
    main()
