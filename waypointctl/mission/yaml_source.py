"""Read any pydantic model from a YAML file, and report each problem with its line and column.

    recipe = read_model(read_source(path, RecipeError), str(path), Recipe, RecipeError)

A model that people write derives from FileModel and gets units in the values; any other pydantic model works.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from pydantic import BaseModel, ValidationError

from waypointctl.display_text import path_text
from waypointctl.errors import InputError
from waypointctl.input_file import read_input, read_start
from waypointctl.mission.problems import Problem, duplicate_problems, problems_of
from waypointctl.mission.yaml_tree import MAX_BYTES, DataPath, Mark, Tree, YamlFault, read_tree
from waypointctl.paths import MCAP, command_for_log
from waypointctl.units import bare_name

M = TypeVar("M", bound=BaseModel)


@dataclass(frozen=True, slots=True)
class Reading(Generic[M]):
    """Result of reading a file: the model, or the problems in the file."""

    model: M | None
    problems: tuple[Problem, ...]

    def value(self, error: type[InputError]) -> M:
        """Return the model; raises an InputError of the type `error` that lists the problems, if there are any."""
        if self.model is None:
            raise as_error(self.problems, error)
        return self.model


def read_source(path: Path, error: type[InputError], most: int = MAX_BYTES, *, within: Path | None = None) -> bytes:
    """Return the bytes of the file at `path`.

    Args:
        path: of the file.
        error: the type of what is raised.
        most: bytes that it may have.
        within: the folder that a link must not lead out of; None where the user named the file.

    Raises:
        InputError: of the type `error`: it does not exist, is irregular, lies elsewhere, is too large or is a log.
    """
    if read_start(path, len(MCAP), error, within=within) == MCAP:
        raise error(command_for_log(str(path)), where=str(path))
    return read_input(path, most, error, within=within)


def read_model(source: bytes, where: str, model: type[M], error: type[InputError]) -> M:
    """Return the model that a YAML text holds.

    Args:
        source: the text.
        where: the file's name, for the messages.
        model: what the text has to be.
        error: what to raise.

    Raises:
        InputError: of the type `error`, with all that is wrong, one "file:line:column: field: problem" a line.
    """
    return examine(source, where, model).value(error)


def examine(source: bytes, where: str, model: type[M]) -> Reading[M]:
    """Return the model that a YAML text holds, or everything that is wrong with the text in the order of its lines."""
    tree = tree_or_problem(source, where)
    return Reading(None, (tree,)) if isinstance(tree, Problem) else examine_tree(tree, where, model)


def tree_or_problem(source: bytes, where: str) -> Tree | Problem:
    """Return the data of a YAML text with its places, or why it cannot be read."""
    try:
        return read_tree(source)
    except YamlFault as fault:
        return Problem(where, fault.mark.line, fault.mark.column, "", fault.text)


def problem_at(tree: Tree, where: str, path: DataPath, text: str) -> Problem:
    """Return a problem with the value at a path of a file's data."""
    mark = tree.values[path]
    return Problem(where, mark.line, mark.column, path_text(path), text)


def examine_tree(tree: Tree, where: str, model: type[M]) -> Reading[M]:
    """Return the model that a file's data holds, or everything that is wrong with it in the order of the lines."""
    problems = duplicate_problems(tree, where)
    value = None
    try:
        value = model.model_validate(tree.data)
    except ValidationError as error:
        problems += problems_of(error, tree, where, model)
    if problems:
        return Reading(None, tuple(sorted(problems, key=lambda problem: (problem.line, problem.column))))
    return Reading(value, ())


def as_error(problems: tuple[Problem, ...], error: type[InputError]) -> InputError:
    """Return one error that lists the problems, one a line."""
    first, *others = problems
    if not others:
        return error(first.sentence, where=first.place)
    return error(f"{len(problems)} problems", where=first.where, details=[str(problem) for problem in problems])


def written_at(tree: Tree, path: DataPath) -> tuple[str, Mark]:
    """Return a place in a model as the file writes it, and where; of what is left to a default the part around it.

    What is written nowhere goes by its bare name.

    Args:
        tree: of the file.
        path: by the fields' names; a key may be written without its unit, and what is for each way of a link once.
    """
    written: DataPath = ()
    for part in path:
        names = (part, bare_name(part)) if isinstance(part, str) else (part,)
        found = next((name for name in names if name is not None and (*written, name) in tree.values), None)
        if found is not None:
            written = (*written, found)
        elif part not in ("up", "down"):
            break
    mark = tree.keys.get(written) or tree.values.get(written)
    bare = [(bare_name(part) or part) if isinstance(part, str) else part for part in path]
    return path_text(written) or path_text(bare), mark or Mark(1, 1)
