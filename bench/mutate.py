"""Change the code in one place at a time, and see whether a test fails: `make mutate`.

    python bench/mutate.py                             all parts, all mutants: hours
    python bench/mutate.py executive link --sample 50  50 mutants drawn over these parts

Each mutant is one change of one module: a comparison, a boolean, a number, an arithmetic sign, a guard or a call
left out. It runs against its part's fast tests in a forked process with a time limit; the first failure kills it. What
was run is kept in runs/mutation/ and not run again while module and tests are the same. Survivors that behave as the
original does are listed with the reason in bench/equivalent_mutants.txt. Exit code 1: less than 95 % were killed.
"""

from __future__ import annotations

import argparse
import ast
import contextlib
import hashlib
import importlib.abc
import importlib.util
import json
import os
import random
import signal
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import CodeType, ModuleType
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[1]
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
        tuple(f"waypointctl/replay/{name}.py" for name in ("verify", "comparator", "compared", "difference")),
        ("tests/replay/test_difference.py", "tests/replay/test_verify.py", "tests/replay/test_verify_[ack]*.py"),
    ),
    "bundle": Part(("waypointctl/policy/bundle.py", "waypointctl/policy/manifest.py"), ("tests/policy/test_*.py",)),
}
_SLOW: Final = (
    "test_fuzzed_commands.py",
    "test_any_order.py",
    "test_direction_by_events.py",
)  # seconds for each mutant

_PYTEST: Final = ("-x", "-q", "-m", "not slow", "--assert=plain", "-p", "no:cacheprovider", "-p", "no:xdist")
_COMPARE: Final[dict[type[ast.cmpop], type[ast.cmpop]]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_ARITHMETIC: Final[dict[type[ast.operator], type[ast.operator]]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.FloorDiv, ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult,
}  # fmt: skip
_CALLS: Final = {"min": "max", "max": "min", "any": "all", "all": "any"}


@dataclass(frozen=True)
class Mutant:
    """One change: the number of its place in the module's tree, which of the changes there, and its name."""

    part: str
    path: str
    site: int
    variant: int
    name: str  # path, function, source line and change: the same while that line is the same


def changes(node: ast.AST) -> list[tuple[str, ast.AST]]:
    """Return what a node may be replaced by, each with what is said of it."""
    match node:
        case ast.If(_, body, orelse) if isinstance(body[-1], ast.Return | ast.Continue | ast.Raise):
            return [("guard left out", ast.If(ast.Constant(False), body, orelse))]
        case ast.Expr(ast.Call()):
            return [("call left out", ast.Pass())]
        case ast.AugAssign(target, _, value):
            return [("assigned, not added", ast.Assign([target], value))]
        case ast.IfExp(test, body, orelse):
            return [("branches swapped", ast.IfExp(test, orelse, body))]
        case ast.Call(ast.Name(name), arguments, keywords) if name in _CALLS:
            called = ast.Name(_CALLS[name], ast.Load())
            return [(f"{name} -> {called.id}", ast.Call(called, arguments, keywords))]
    return _changed_operators(node)


def _changed_operators(node: ast.AST) -> list[tuple[str, ast.AST]]:
    match node:
        case ast.Compare(left, [operator], [right]) if type(operator) in _COMPARE:
            other = _COMPARE[type(operator)]()
            return [(f"{_word(operator)} -> {_word(other)}", ast.Compare(left, [other], [right]))]
        case ast.BoolOp(op, values):
            swapped: ast.boolop = ast.Or() if isinstance(op, ast.And) else ast.And()
            return [(f"{_word(op)} -> {_word(swapped)}", ast.BoolOp(swapped, values))]
        case ast.UnaryOp(ast.Not(), operand):
            return [("not left out", operand)]
        case ast.BinOp(left, operation, right) if type(operation) in _ARITHMETIC:
            change = _ARITHMETIC[type(operation)]()
            return [(f"{_word(operation)} -> {_word(change)}", ast.BinOp(left, change, right))]
        case ast.Constant(bool() as value):
            return [(f"{value} -> {not value}", ast.Constant(not value))]
        case ast.Constant(int() | float() as value):
            return [(f"{value} -> {value + 1}", ast.Constant(value + 1))]
    return []


def _word(node: ast.AST) -> str:
    return type(node).__name__


def sites(tree: ast.AST) -> Iterator[tuple[ast.AST, str, int, ast.AST]]:
    """Yield each node that may be replaced, with its parent's field: (parent, field, index or -1, node), in order."""
    for name, value in ast.iter_fields(tree):
        if name in ("annotation", "returns", "decorator_list", "exc", "bases"):
            continue
        for index, child in enumerate(value if isinstance(value, list) else [value]):
            if not isinstance(child, ast.AST) or isinstance(
                child, ast.JoinedStr | ast.Assert | ast.Import | ast.ImportFrom
            ):
                continue
            if isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
                continue  # a docstring
            yield tree, name, index if isinstance(value, list) else -1, child
            yield from sites(child)


def mutants_of(part: str, path: Path) -> list[Mutant]:
    """Return every mutant of a module."""
    source = path.read_text()
    tree, lines, found = ast.parse(source), source.splitlines(), []
    functions = [it for it in ast.walk(tree) if isinstance(it, ast.FunctionDef | ast.ClassDef)]
    seen: Counter[str] = Counter()
    relative = str(path.relative_to(ROOT))
    for number, (_, _, _, node) in enumerate(sites(tree)):
        for variant, (text, _) in enumerate(changes(node)):
            line = getattr(node, "lineno", 0)
            around = ".".join(it.name for it in functions if it.lineno <= line <= (it.end_lineno or 0))
            name = f"{relative} | {around} | {lines[line - 1].strip()} | {text}"
            seen[name] += 1
            found.append(Mutant(part, relative, number, variant, name + f" | {seen[name]}" * (seen[name] > 1)))
    return found


def mutated(mutant: Mutant) -> CodeType:
    """Return the module's code with the change in it."""
    tree = ast.parse((ROOT / mutant.path).read_text())
    parent, field, index, node = list(sites(tree))[mutant.site]
    new = ast.copy_location(changes(node)[mutant.variant][1], node)
    if index < 0:
        setattr(parent, field, new)
    else:
        getattr(parent, field)[index] = new
    return compile(ast.fix_missing_locations(tree), str(ROOT / mutant.path), "exec")


class _Finder(importlib.abc.MetaPathFinder, importlib.abc.InspectLoader):
    """Loads one module from the code that is given; all else is found as ever."""

    def __init__(self, mutant: Mutant) -> None:
        self._name = mutant.path.removesuffix(".py").replace("/", ".")
        self._path, self._code = str(ROOT / mutant.path), mutated(mutant)

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if fullname != self._name:
            return None
        spec = importlib.util.spec_from_loader(fullname, self, origin=self._path)
        assert spec is not None
        spec.has_location = True
        return spec

    def get_code(self, fullname: str) -> CodeType:
        return self._code

    def get_source(self, fullname: str) -> str:
        return Path(self._path).read_text()


def tests_of(part: Part) -> list[str]:
    """Return the files of a part's fast tests."""
    return [str(path) for pattern in part.tests for path in sorted(ROOT.glob(pattern)) if path.name not in _SLOW]


def start(tests: Sequence[str], mutant: Mutant | None) -> int:
    """Run tests in a forked process, with a mutant in place of its module; return the process's id."""
    child = os.fork()
    if child:
        return child
    os.setsid()
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1), os.dup2(silence, 2)
    code = 1
    with contextlib.suppress(BaseException):
        if mutant is not None:
            sys.meta_path.insert(0, _Finder(mutant))
        import pytest

        code = int(pytest.main([*_PYTEST, *tests]))
    os._exit(0 if code == 0 else 1)


def wait(child: int, limit_s: float) -> str:
    """Return what became of a run of tests: "survived", "killed" or "timeout"."""
    end_s = time.monotonic() + limit_s
    while time.monotonic() < end_s:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return "survived" if status == 0 else "killed"
        time.sleep(0.02)
    os.killpg(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return "timeout"


def preload() -> None:
    """Load what each forked process needs and no mutant changes."""
    sys.path.insert(0, str(ROOT))
    os.chdir(ROOT)
    os.environ["OMP_NUM_THREADS"] = "1"
    for name in ("numpy", "pytest", "hypothesis", "pydantic", "mujoco", "yaml", "mcap.writer", "zstandard"):
        with contextlib.suppress(ImportError):
            importlib.import_module(name)


def stamp(mutant: Mutant, tests: Sequence[str]) -> str:
    """Return a hash of a mutant's module and of the tests: with another one it is run again."""
    digest = hashlib.sha256((ROOT / mutant.path).read_bytes())
    for path in tests:
        digest.update(Path(path).read_bytes())
    return digest.hexdigest()[:12]


def _results(part: str) -> dict[str, list[str]]:
    """Return what became of a part's mutants so far: the stamp and the end of each, by name."""
    path = RESULTS / f"{part}.json"
    return json.loads(path.read_text()) if path.exists() else {}


def run(chosen: Sequence[Mutant]) -> dict[str, str]:
    """Run mutants that were not run before; return what became of each, by name."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    before: dict[str, dict[str, list[str]]] = {part: _results(part) for part in {mutant.part for mutant in chosen}}
    found, limits = {}, dict[str, float]()
    for count, mutant in enumerate(chosen, 1):
        tests = tests_of(PARTS[mutant.part])
        mark = stamp(mutant, tests)
        known = before[mutant.part]
        if known.get(mutant.name, [""])[0] != mark:
            if mutant.part not in limits:
                begun_s = time.monotonic()
                if wait(start(tests, None), 600) != "survived":
                    sys.exit(f"{mutant.part}: the tests fail without a mutant")
                limits[mutant.part] = 5 * (time.monotonic() - begun_s) + 10
            known[mutant.name] = [mark, wait(start(tests, mutant), limits[mutant.part])]
            new = RESULTS / f"{mutant.part}.new"
            new.write_text(json.dumps(known, indent=0))
            new.replace(new.with_suffix(".json"))
        found[mutant.name] = known[mutant.name][1]
        print(f"\r{count}/{len(chosen)}, {sum(it == 'survived' for it in found.values())} survived", end="", flush=True)
    print()
    return found


def main() -> int:
    """Do what the command line asks."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(PARTS)}; all of them")
    parser.add_argument("--sample", type=int, help="so many mutants, drawn over all of the parts")
    parser.add_argument("--seed", type=int, default=0, help="of the draw")
    given = parser.parse_args()
    if unknown := set(given.parts) - set(PARTS):
        parser.error(f"no part {', '.join(sorted(unknown))}; choose from {', '.join(PARTS)}")
    preload()
    mutants = [
        mutant
        for part in given.parts or PARTS
        for pattern in PARTS[part].modules
        for path in sorted(ROOT.glob(pattern))
        for mutant in mutants_of(part, path)
    ]
    drawn = random.Random(given.seed).sample(mutants, min(given.sample or len(mutants), len(mutants)))
    chosen = sorted(drawn, key=lambda it: (it.part, it.path, it.site, it.variant))
    reasons = [line.rpartition(" # ")[0] for line in EQUIVALENT.read_text().splitlines() if " # " in line]
    found = run(chosen)
    survived = [name for name, what in found.items() if what == "survived" and name not in reasons]
    counted = sum(not (what == "survived" and name in reasons) for name, what in found.items())
    share = 1 - len(survived) / counted if counted else 1.0
    print("\n".join(survived))
    print(f"{len(found)} of {len(mutants)} mutants run, {share:.1%} of {counted} that differ killed")
    return 0 if share >= WANTED else 1


if __name__ == "__main__":
    sys.exit(main())
