"""The files that a mission refers to: read with it, checked with it, and carried wherever it goes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, TypeAlias

from waypointctl.errors import MissionError
from waypointctl.input_file import NOT_THERE
from waypointctl.mission.checks import file_beside
from waypointctl.mission.contact_plan import ANY_MOMENT, Passage, is_moment, read_contact_plan
from waypointctl.mission.link import LinkDirection
from waypointctl.mission.mission import Mission
from waypointctl.mission.policy_name import from_folder
from waypointctl.mission.problems import Problem
from waypointctl.mission.text_file import read_jitter
from waypointctl.mission.wording import path_text
from waypointctl.mission.yaml_source import Reading, examine_tree, read_source
from waypointctl.mission.yaml_tree import DataPath, Tree, YamlFault, read_tree
from waypointctl.paths import command_for_plan

ReadFile: TypeAlias = Callable[[str], bytes]  # the content of a file by its name in the mission; may raise MissionError

_JITTER: Final = ("jitter_file",)
_PLAN: Final = ("contact_plan", "file")


def beside(path: Path) -> ReadFile:
    """Return what reads the files that the mission at `path` refers to."""
    return lambda name: read_source(path.parent / name, MissionError, within=path.parent)


def among(files: Mapping[str, bytes]) -> ReadFile:
    """Return what reads from files that were read before."""

    def read(name: str) -> bytes:
        if name not in files:
            raise MissionError(NOT_THERE, where=name)
        return files[name]

    return read


def examine_mission(source: bytes, where: str, read: ReadFile) -> Reading[Mission]:
    """Return the mission that a YAML text holds, with its files, or everything that is wrong with all of them.

    Args:
        source: the text.
        where: the mission file's name, for the messages; the names of its files are relative to it.
        read: reads a file that the mission refers to.
    """
    if plan := command_for_plan(where):
        return Reading(None, (Problem(where, 0, 0, "", plan),))
    try:
        tree = read_tree(source)
    except YamlFault as fault:
        line, column = (fault.mark.line, fault.mark.column) if fault.mark else (0, 0)
        return Reading(None, (Problem(where, line, column, "", fault.text),))
    reading = examine_tree(tree, where, Mission)
    files: dict[str, bytes] = {}
    problems = list(reading.problems)
    for path, name in _references(tree):
        try:
            files[name] = read(name)
        except MissionError as error:
            mark = tree.values[path]
            place = str(Path(where).parent / name)
            problems.append(
                Problem(where, mark.line, mark.column, path_text(path), f"{place} {_as_predicate(error.problem)}")
            )
    problems.sort(key=lambda problem: (problem.line, problem.column))
    inside = _problems_inside(tree, reading.model, files, Path(where).parent)
    problems += [_with_reference(problem, tree, where) for problem in inside]
    if problems or reading.model is None:
        return Reading(None, tuple(problems))
    robot = from_folder(reading.model.robot, Path(where).parent)
    return Reading(reading.model.model_copy(update={"robot": robot}).with_files(files), ())


def _with_reference(problem: Problem, tree: Tree, where: str) -> Problem:
    """Return a problem of a whole file at the mission's key that names the file; else as it is."""
    if problem.line:
        return problem
    folder = Path(where).parent
    path = next(path for path, name in _references(tree) if str(folder / name) == problem.where)
    mark = tree.values[path]
    return Problem(where, mark.line, mark.column, path_text(path), f"{problem.where} {problem.text}")


def _as_predicate(problem: str) -> str:
    return "does not exist" if problem == NOT_THERE else problem


def _references(tree: Tree) -> Iterator[tuple[DataPath, str]]:
    """Yield where the mission's data names a file, and the name; not those that the mission's own rules refuse."""
    for way in ((), ("up",), ("down",)):
        for field in (_JITTER, _PLAN):
            path: DataPath = ("link", *way, *field)
            name = _at(tree.data, path)
            if isinstance(name, str) and _is_beside(name):
                yield path, name


def _at(data: Any, path: DataPath) -> Any:
    for part in path:
        data = data.get(part) if isinstance(data, dict) else None
    return data


def _is_beside(name: str) -> bool:
    try:
        return bool(file_beside(name))
    except ValueError:
        return False


def _problems_inside(tree: Tree, mission: Mission | None, files: Mapping[str, bytes], folder: Path) -> list[Problem]:
    """Return the problems in the files; without a mission, those that no mission could avoid."""
    found: list[Problem] = []
    if mission is None:
        for path, name in _references(tree):
            if name in files:
                found += _problems_anyway(tree, path, files[name], str(folder / name))
        return _one_a_cause(found)
    for way in (mission.link.up, mission.link.down):
        plan, passage = way.contact_plan, None
        if plan is not None and plan.file in files:
            place, needed = str(folder / plan.file), not way.has_own_delay
            passage, problems = read_contact_plan(
                files[plan.file], place, plan.way, reference=plan.reference, needs_ranges=needed
            )
            found += problems
        if way.jitter_file is not None and way.jitter_file in files:
            place = str(folder / way.jitter_file)
            found += read_jitter(files[way.jitter_file], place, _least_delay_s(way, passage))[1]
    return _one_a_cause(found)


def _one_a_cause(problems: Iterable[Problem]) -> list[Problem]:
    """Return the first problem of each text and file, with the number of the others."""
    causes: dict[tuple[str, str], list[Problem]] = {}
    for problem in dict.fromkeys(problems):
        causes.setdefault((problem.where, problem.text), []).append(problem)
    return [
        replace(first, text=f"{first.text} (and {len(others):,} more of the kind, the last in line {others[-1].line})")
        if others
        else first
        for first, *others in causes.values()
    ]


def _least_delay_s(way: LinkDirection, passage: Passage | None) -> float | None:
    """Return the shortest one-way delay of a direction without its jitter [s]; None where it is not known."""
    if not way.has_own_delay:
        return min((each.value for each in passage.ranges), default=None) if passage is not None else None
    return way.delay_s if way.delay_table is None else min(row.delay_s for row in way.delay_table)


def _problems_anyway(tree: Tree, path: DataPath, source: bytes, place: str) -> tuple[Problem, ...]:
    """Return what is wrong in the file named at `path`, where the mission that names it is wrong itself."""
    if path[-1:] == _JITTER:
        return read_jitter(source, place)[1]
    reference, *way = (_at(tree.data, (*path[:-1], key)) for key in ("reference", "from_node", "to_node"))
    if not all(type(node) is int for node in way):
        return ()  # which lines matter is not known
    if reference is not None and not (isinstance(reference, str) and is_moment(reference)):
        reference = ANY_MOMENT  # the mission's problem is reported already
    return read_contact_plan(source, place, (way[0], way[1]), reference=reference, needs_ranges=False)[1]
