"""What became of a part's mutants, kept in runs/mutation/ for as long as the module and the tests do the same."""

from __future__ import annotations

import ast
import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Final

from bench.mutant_runs import Measured, Outcome
from bench.mutants import ROOT, Mutant

FOLDER: Final = ROOT / "runs" / "mutation"


@cache
def _code(path: str) -> bytes:
    """Return what a file does, without its comments and docstrings."""
    tree = ast.parse((ROOT / path).read_bytes())
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node) is not None:
            del node.body[0]
    return ast.dump(tree).encode()


def _hash(contents: Iterable[bytes]) -> str:
    digest = hashlib.sha256()
    for content in contents:
        digest.update(content)
    return digest.hexdigest()[:12]


@cache
def _stamp(*paths: str) -> str:
    return _hash(map(_code, paths))


def _write(path: Path, content: object) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    new = path.with_suffix(".new")
    new.write_text(json.dumps(content, indent=0))
    new.replace(path)


class Results:
    """The results of a part.

    Attributes:
        modules: its files, as paths in the repository.
        tests: the files of its tests, likewise.
        known: stamp, end and the test that failed, by the mutant's name.
    """

    def __init__(self, part: str, modules: Sequence[str], tests: Sequence[str]) -> None:
        """Read what is kept of a part."""
        self.modules, self.tests = modules, tests
        self._path, self._measured_path = FOLDER / f"{part}.json", FOLDER / f"{part}.tests.json"
        self.known: dict[str, list[str]] = json.loads(self._path.read_text()) if self._path.exists() else {}

    def missing(self, mutants: Iterable[Mutant]) -> list[Mutant]:
        """Return the mutants that were not run with what the files do now."""
        return [it for it in mutants if not self._is_known(it)]

    def add(self, outcome: Outcome) -> None:
        """Keep what became of a mutant."""
        mutant, what, test = outcome
        self.known[mutant.name] = [self._mark(mutant.path, what, test), what, test]
        _write(self._path, self.known)

    def measured(self) -> dict[str, Measured] | None:
        """Return what the tests run, if it was measured with the files as they are: lines move with comments too."""
        path = self._measured_path
        if not path.exists() or (kept := json.loads(path.read_text()))["stamp"] != self._files():
            return None
        return {test: Measured(**its) for test, its in kept["tests"].items()}

    def keep(self, measured: dict[str, Measured]) -> dict[str, Measured]:
        """Keep what the tests run, and return it."""
        tests = {test: asdict(its) for test, its in measured.items()}
        _write(self._measured_path, {"stamp": self._files(), "tests": tests})
        return measured

    def _files(self) -> str:
        return _hash((ROOT / path).read_bytes() for path in (*self.modules, *self.tests))

    def _is_known(self, mutant: Mutant) -> bool:
        if mutant.name not in self.known:
            return False
        mark, what, test = self.known[mutant.name]
        return mark == self._mark(mutant.path, what, test)

    def _mark(self, path: str, what: str, test: str) -> str:
        """Return a hash of the module and of what decided: the file of the test that failed, or all of the tests."""
        file = test.partition("::")[0]
        return _stamp(path, *([file] if what == "killed" and file in self.tests else self.tests))
