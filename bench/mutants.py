"""What a mutant is: one change of one place in a module's syntax tree, and the code that this makes."""

from __future__ import annotations

import ast
import importlib.abc
import importlib.util
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import CodeType, ModuleType
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[1]

_COMPARE: Final[dict[type[ast.cmpop], type[ast.cmpop]]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_ARITHMETIC: Final[dict[type[ast.operator], type[ast.operator]]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.FloorDiv, ast.FloorDiv: ast.Mult, ast.Mod: ast.Mult,
}  # fmt: skip
_CALLS: Final = {"min": "max", "max": "min", "any": "all", "all": "any"}
_NOT_RUN: Final = ("annotation", "returns", "decorator_list", "exc", "bases")


@dataclass(frozen=True)
class Mutant:
    """One change: the number of its place in the module's tree, which of the changes there, and its name."""

    part: str
    path: str
    site: int
    variant: int
    name: str  # path, function, source line and change: the same while that line is the same
    lines: frozenset[int]  # of the statement's own lines: a test that runs none of them cannot notice


@dataclass(frozen=True)
class Site:
    """A node that may be replaced: `node` is `parent.field`, or its element `index` where that is not -1."""

    parent: ast.AST
    field: str
    index: int
    node: ast.AST
    statement: ast.stmt | None  # the innermost one that the node is, or is part of


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


def sites(tree: ast.AST, statement: ast.stmt | None = None) -> Iterator[Site]:
    """Yield each node below a tree that may be replaced, in order."""
    for name, value in ast.iter_fields(tree):
        if name in _NOT_RUN:
            continue
        for index, child in enumerate(value if isinstance(value, list) else [value]):
            if not isinstance(child, ast.AST) or isinstance(
                child, ast.JoinedStr | ast.Assert | ast.Import | ast.ImportFrom
            ):
                continue
            if isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant):
                continue  # a docstring
            own = child if isinstance(child, ast.stmt) else statement
            yield Site(tree, name, index if isinstance(value, list) else -1, child, own)
            yield from sites(child, own)


def _own_lines(site: Site) -> frozenset[int]:
    """Return the lines of a node, and of its statement without the statements in that one."""
    lines: set[int] = set()
    for node in (site.node, site.statement):
        if not isinstance(node, ast.stmt | ast.expr):
            continue
        lines.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
        for inner in ast.walk(node):
            if isinstance(inner, ast.stmt) and inner is not node:
                lines.difference_update(range(inner.lineno, (inner.end_lineno or inner.lineno) + 1))
    return frozenset(lines)


def mutants_of(part: str, path: Path) -> list[Mutant]:
    """Return every mutant of a module."""
    source = path.read_text()
    tree, lines, found = ast.parse(source), source.splitlines(), []
    functions = [it for it in ast.walk(tree) if isinstance(it, ast.FunctionDef | ast.ClassDef)]
    seen: Counter[str] = Counter()
    relative = str(path.relative_to(ROOT))
    for number, site in enumerate(sites(tree)):
        for variant, (text, _) in enumerate(changes(site.node)):
            line = getattr(site.node, "lineno", 0)
            around = ".".join(it.name for it in functions if it.lineno <= line <= (it.end_lineno or 0))
            name = f"{relative} | {around} | {lines[line - 1].strip()} | {text}"
            seen[name] += 1
            full = name + f" | {seen[name]}" * (seen[name] > 1)
            found.append(Mutant(part, relative, number, variant, full, _own_lines(site)))
    return found


def mutated(mutant: Mutant) -> CodeType:
    """Return the module's code with the change in it."""
    tree = ast.parse((ROOT / mutant.path).read_text())
    site = list(sites(tree))[mutant.site]
    new = ast.copy_location(changes(site.node)[mutant.variant][1], site.node)
    if site.index < 0:
        setattr(site.parent, site.field, new)
    else:
        getattr(site.parent, site.field)[site.index] = new
    return compile(ast.fix_missing_locations(tree), str(ROOT / mutant.path), "exec", dont_inherit=True)


def functions_in(code: CodeType) -> Iterator[CodeType]:
    """Yield the code of all that is in a module's code, at any depth."""
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield constant
            yield from functions_in(constant)


class MutantFinder(importlib.abc.MetaPathFinder, importlib.abc.InspectLoader):
    """Loads one module from the code that is given; all else is found as ever."""

    def __init__(self, path: str, code: CodeType) -> None:
        """Take the module's path in the repository, and its code."""
        self._name = path.removesuffix(".py").replace("/", ".")
        self._path, self._code = str(ROOT / path), code

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return how the module is loaded; None for others."""
        if fullname != self._name:
            return None
        spec = importlib.util.spec_from_loader(fullname, self, origin=self._path)
        assert spec is not None
        spec.has_location = True
        return spec

    def get_code(self, fullname: str) -> CodeType:
        """Return the code that was given."""
        return self._code

    def get_source(self, fullname: str) -> str:
        """Return the text without the change."""
        return Path(self._path).read_text()
