"""Change the code in one place at a time, and see whether a test fails: `make mutate`.

    python bench/mutate.py                             all parts, all mutants
    python bench/mutate.py executive link --sample 50  50 mutants drawn over these parts

Each mutant is one change of one module: a comparison, a boolean, a number, an arithmetic sign, a guard or a call
left out. It runs against its part's fast tests in a forked process with a time limit; the first failure kills it. What
was run is kept in runs/mutation/ and not run again while module and tests are the same. Mutants that behave as the
original does are listed with the reason in bench/equivalent_mutants.txt; `--listed` runs them too, and names those that
were killed. Exit code 1: less than 95 % of the others were killed.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib
import json
import os
import random
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Final

from bench.mutant_runs import Items, Measured, Outcome, Trace, collected, measure, run_anew, run_in_place
from bench.mutants import ROOT, Mutant, mutants_of

RESULTS: Final = ROOT / "runs" / "mutation"
EQUIVALENT: Final = ROOT / "bench" / "equivalent_mutants.txt"
WANTED: Final = 0.95
_FLIGHT: Final = "waypointctl/flight"


@dataclass(frozen=True)
class Part:
    """What is mutated together: modules, and the tests that are to notice; both as patterns of paths."""

    modules: tuple[str, ...]
    tests: tuple[str, ...]


PARTS: Final = {
    "executive": Part((f"{_FLIGHT}/executive/*.py",), ("tests/flight/executive/test_*.py",)),
    "operator": Part((f"{_FLIGHT}/operator/*.py",), ("tests/flight/operator/test_*.py",)),
    "link": Part((f"{_FLIGHT}/link/*.py",), ("tests/flight/link/test_*.py",)),
    "command_life": Part((f"{_FLIGHT}/command_life.py",), ("tests/flight/test_command_life.py",)),
    "verify": Part(
        ("waypointctl/replay/verify.py", "waypointctl/replay/comparator.py"),
        (
            "tests/replay/test_difference.py",
            "tests/replay/test_verify.py",
            "tests/replay/test_verify_[ack]*.py",
            "tests/replay/test_comparator.py",
            "tests/replay/test_verify_words.py",
            "tests/replay/test_verify_own_policy.py",
        ),
    ),
    "bundle": Part(("waypointctl/policy/bundle.py", "waypointctl/policy/manifest.py"), ("tests/policy/test_*.py",)),
}
_LIBRARIES: Final = (
    "hypothesis", "matplotlib", "mcap.reader", "mcap.writer", "mjbatch", "mujoco", "numpy", "onnx", "onnxruntime",
    "pydantic", "ruamel.yaml", "safetensors.numpy", "torch", "zstandard",
)  # fmt: skip


def _paths(patterns: Iterable[str]) -> list[str]:
    return [str(path.relative_to(ROOT)) for pattern in patterns for path in sorted(ROOT.glob(pattern))]


@cache
def _stamp(*paths: str) -> str:
    """Return a hash of some files: of a module and its tests, say; with another one all is run again."""
    digest = hashlib.sha256()
    for path in paths:
        digest.update((ROOT / path).read_bytes())
    return digest.hexdigest()[:12]


class Results:
    """What became of a part's mutants, kept in a file: stamp, end and the test that failed, by the mutant's name."""

    def __init__(self, part: str) -> None:
        """Read what is kept of a part."""
        self.tests = _paths(PARTS[part].tests)
        self._path = RESULTS / f"{part}.json"
        self.known: dict[str, list[str]] = json.loads(self._path.read_text()) if self._path.exists() else {}

    def _mark(self, path: str, what: str, test: str) -> str:
        """Return a hash of the module and of what decided: the file of the test that failed, or all of the tests."""
        file = test.partition("::")[0]
        return _stamp(path, *([file] if what == "killed" and file in self.tests else self.tests))

    def missing(self, mutants: Iterable[Mutant]) -> list[Mutant]:
        """Return the mutants that were not run with the files as they are."""
        known = self.known
        return [
            it
            for it in mutants
            if it.name not in known or known[it.name][0] != self._mark(it.path, *known[it.name][1:])
        ]

    def add(self, outcome: Outcome) -> None:
        """Keep what became of a mutant."""
        mutant, what, test = outcome
        self.known[mutant.name] = [self._mark(mutant.path, what, test), what, test]
        _write(self._path, self.known)


def _write(path: Path, content: object) -> None:
    new = path.with_suffix(".new")
    new.write_text(json.dumps(content, indent=0))
    new.replace(path)


def _measured(part: str) -> dict[str, Measured] | None:
    """Return what a part's tests run, if it was measured with the files as they are."""
    path, mark = RESULTS / f"{part}.tests.json", _stamp(*_paths(PARTS[part].modules), *_paths(PARTS[part].tests))
    if not path.exists() or (kept := json.loads(path.read_text()))["stamp"] != mark:
        return None
    return {test: Measured(**its) for test, its in kept["tests"].items()}


def _measure(part: str, items: Items, jobs: int) -> dict[str, Measured]:
    modules, tests = _paths(PARTS[part].modules), _paths(PARTS[part].tests)
    measured = measure(items, modules, jobs)
    kept = {"stamp": _stamp(*modules, *tests), "tests": {test: asdict(its) for test, its in measured.items()}}
    _write(RESULTS / f"{part}.tests.json", kept)
    return measured


def _serve(part: str, mutants: Sequence[Mutant], jobs: int) -> int:
    """Collect a part's tests, measure them if need be, and run mutants of what runs after loading; return 0."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    results, trace = Results(part), Trace(_paths(PARTS[part].modules))

    def work(items: Items) -> None:
        at_import = trace.stop()
        later = [it for it in mutants if it.lines.isdisjoint(at_import.get(it.path, ()))]
        measured = _measured(part) or _measure(part, items, jobs)
        for count, outcome in enumerate(run_in_place(later, items, measured, jobs), 1):
            results.add(outcome)
            _show(part, count, len(later))

    trace.start()
    return collected(results.tests, work)


def run(part: str, chosen: Sequence[Mutant], jobs: int) -> None:
    """Run those of a part's mutants that were not run with the files as they are."""
    results = Results(part)
    missing = results.missing(chosen)
    if not missing:
        return
    server = os.fork()
    if not server:
        os._exit(_serve(part, missing, jobs))
    measured = _measured(part) if os.waitpid(server, 0)[1] == 0 else None
    if measured is None:
        sys.exit(f"{part}: its tests cannot be run")
    results = Results(part)
    rest = results.missing(missing)
    for count, outcome in enumerate(run_anew(rest, results.tests, measured, jobs), 1):
        results.add(outcome)
        _show(f"{part}, loaded anew", count, len(rest))


def _show(what: str, count: int, of: int) -> None:
    print(f"\r{what}: {count}/{of}", end="\n" if count == of else "", flush=True, file=sys.stderr)


def preload() -> None:
    """Load what each process needs and no mutant changes; random tests draw the same and do not seek small examples."""
    os.chdir(ROOT)
    os.environ["OMP_NUM_THREADS"] = "1"
    for name in _LIBRARIES:
        importlib.import_module(name)
    from hypothesis import Phase, settings

    settings.register_profile(
        "mutate", database=None, derandomize=True, deadline=None, phases=(Phase.explicit, Phase.generate)
    )
    settings.load_profile("mutate")


def _listed() -> set[str]:
    """Return the names of the mutants that are listed as equivalent."""
    return {line.rpartition(" # ")[0] for line in EQUIVALENT.read_text().splitlines()[1:]}


def report(chosen: Sequence[Mutant], minutes: Mapping[str, float]) -> bool:
    """Print each survivor and a table; return whether enough mutants were killed."""
    table, all_differing, all_killed = [], 0, 0
    for part in minutes:
        known, names = Results(part).known, [it.name for it in chosen if it.part == part]
        ends = {name: known.get(name, ["", "survived", ""])[1:] for name in names}
        equivalent = [name for name in names if name in _listed()]
        for name in equivalent:
            if ends[name][0] != "survived":
                print(f"killed, but listed as equivalent: {name}")
        differing = [name for name in names if name not in equivalent]
        survived = [name for name in differing if ends[name][0] == "survived"]
        for name in survived:
            print(f"survived: {name}{f' ({ends[name][1]})' if ends[name][1] else ''}")
        killed = len(differing) - len(survived)
        all_differing, all_killed = all_differing + len(differing), all_killed + killed
        counts = (len(names), killed, len(equivalent), len(survived))
        table.append(f"{part:14}" + "".join(f"{count:12}" for count in counts) + f"{minutes[part]:12.1f}")
    print(f"{'part':14}" + "".join(f"{it:>12}" for it in ("mutants", "killed", "equivalent", "survived", "minutes")))
    print("\n".join(table))
    share = all_killed / all_differing if all_differing else 1.0
    print(f"{share:.1%} of {all_differing} that differ killed")
    return share >= WANTED


def main() -> int:
    """Do what the command line asks."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)}; all of them")
    parser.add_argument("--sample", type=int, help="so many mutants, drawn over all of the parts")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="so many mutants at once")
    parser.add_argument("--listed", action="store_true", help="run also what is listed as equivalent")
    given = parser.parse_args()
    if unknown := set(given.parts) - set(PARTS):
        parser.error(f"no part {', '.join(sorted(unknown))}; choose from {', '.join(PARTS)}")
    parts = given.parts or list(PARTS)
    mutants = [it for part in parts for path in _paths(PARTS[part].modules) for it in mutants_of(part, ROOT / path)]
    drawn = random.Random(given.seed).sample(mutants, min(given.sample or len(mutants), len(mutants)))
    chosen = sorted(drawn, key=lambda it: (it.part, it.path, it.site, it.variant))
    skipped = set() if given.listed else _listed()
    for name in sorted(_listed() - {it.name for it in mutants}) if parts == list(PARTS) else ():
        print(f"listed as equivalent, but there is no such mutant: {name}")
    preload()
    RESULTS.mkdir(parents=True, exist_ok=True)
    minutes = dict[str, float]()
    for part in parts:
        begun_s = time.monotonic()
        run(part, [it for it in chosen if it.part == part and it.name not in skipped], given.jobs)
        minutes[part] = (time.monotonic() - begun_s) / 60
    return 0 if report(chosen, minutes) else 1


if __name__ == "__main__":
    sys.exit(main())
