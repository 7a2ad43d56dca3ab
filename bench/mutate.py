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
import importlib
import os
import random
import sys
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from bench.mutant_runs import Items, Trace, collected, measure, run_anew, run_in_place
from bench.mutants import ROOT, Mutant, mutants_of
from bench.mutation_results import Results

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
    "command_life": Part(
        (f"{_FLIGHT}/command_life.py",),
        ("tests/flight/test_command_life.py", "tests/flight/executive/test_command_tracker.py"),
    ),
    "verify": Part(
        ("waypointctl/replay/verify.py", "waypointctl/replay/comparator.py"),
        (
            "tests/replay/test_difference.py",
            "tests/replay/test_verify_[ack]*.py",
            "tests/replay/test_comparator.py",
            "tests/replay/test_verify_words.py",
            "tests/replay/test_verify_own_policy.py",
        ),
    ),
    "bundle": Part(
        ("waypointctl/policy/bundle.py", "waypointctl/policy/manifest.py", "waypointctl/policy/manifest_file.py"),
        ("tests/policy/test_*.py",),
    ),
}
_LIBRARIES: Final = (
    "hypothesis", "matplotlib", "mcap.reader", "mcap.writer", "mjbatch", "mujoco", "numpy", "onnx", "onnxruntime",
    "pydantic", "ruamel.yaml", "safetensors.numpy", "torch", "zstandard",
)  # fmt: skip


def _paths(patterns: Iterable[str]) -> list[str]:
    return [str(path.relative_to(ROOT)) for pattern in patterns for path in sorted(ROOT.glob(pattern))]


def _results(part: str) -> Results:
    return Results(part, _paths(PARTS[part].modules), _paths(PARTS[part].tests))


def _serve(part: str, mutants: Sequence[Mutant], jobs: int) -> int:
    """Collect a part's tests, measure them if need be, and run mutants of what runs after loading; return 0."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    results = _results(part)
    trace = Trace(results.modules)

    def work(items: Items) -> None:
        at_import = trace.stop()
        later = [it for it in mutants if it.lines.isdisjoint(at_import.get(it.path, ()))]
        measured = results.measured() or results.keep(measure(items, results.modules, jobs))
        for count, outcome in enumerate(run_in_place(later, items, measured, jobs), 1):
            results.add(outcome)
            _show(part, count, len(later))

    trace.start()
    return collected(results.tests, work)


def run(part: str, chosen: Sequence[Mutant], jobs: int) -> None:
    """Run those of a part's mutants that were not run with the files as they are."""
    results = _results(part)
    missing = results.missing(chosen)
    if not missing:
        return
    server = os.fork()
    if not server:
        os._exit(_serve(part, missing, jobs))
    ended = os.waitpid(server, 0)[1]
    results = _results(part)
    measured = results.measured() if ended == 0 else None
    if measured is None:
        sys.exit(f"{part}: its tests cannot be run")
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
        known, names = _results(part).known, [it.name for it in chosen if it.part == part]
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
    minutes = dict[str, float]()
    for part in parts:
        begun_s = time.monotonic()
        run(part, [it for it in chosen if it.part == part and it.name not in skipped], given.jobs)
        minutes[part] = (time.monotonic() - begun_s) / 60
    return 0 if report(chosen, minutes) else 1


if __name__ == "__main__":
    sys.exit(main())
