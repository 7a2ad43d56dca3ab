"""Missions as YAML files, in and out, with the files that they refer to; the JSON Schema for editors."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeAlias

from waypointctl.errors import MissionError, given_path
from waypointctl.input_file import NOT_THERE
from waypointctl.mission.checks import SCHEMA_VERSION
from waypointctl.mission.contact_plan import Passage, read_contact_plan
from waypointctl.mission.fields import file_beside
from waypointctl.mission.file_kind import command_for_keys
from waypointctl.mission.link import LinkDirection
from waypointctl.mission.mission import Mission
from waypointctl.mission.policy_name import from_folder, policy_folder
from waypointctl.mission.problems import Problem
from waypointctl.mission.text_file import ANY_MOMENT, moment_of, read_jitter
from waypointctl.mission.yaml_source import Reading, examine_tree, problem_at, read_source, tree_or_problem
from waypointctl.mission.yaml_tree import DataPath, Tree, read_tree
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
    tree = tree_or_problem(source, where)
    if isinstance(tree, Problem):
        return Reading(None, (tree,))
    if other := command_for_keys(tree.data, where):
        return Reading(None, (Problem(where, 0, 0, "", other),))
    reading = examine_tree(tree, where, Mission)
    files: dict[str, bytes] = {}
    problems = list(reading.problems)
    for path, name in _references(tree):
        try:
            files[name] = read(name)
        except MissionError as error:
            problem = "does not exist" if error.problem == NOT_THERE else error.problem
            problems.append(problem_at(tree, where, path, f"{Path(where).parent / name} {problem}"))
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
    return problem_at(tree, where, path, f"{problem.where} {problem.text}")


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
    if reference is not None and (not isinstance(reference, str) or moment_of(reference) is None):
        reference = ANY_MOMENT  # the mission's problem is reported already
    return read_contact_plan(source, place, (way[0], way[1]), reference=reference, needs_ranges=False)[1]


@dataclass(frozen=True, slots=True)
class MissionFile:
    """A mission and the file that it came from."""

    mission: Mission
    source: bytes
    path: Path

    @property
    def files(self) -> Mapping[str, bytes]:
        """The contents of the files that the mission refers to, by their names in it."""
        return self.mission.files

    @property
    def policy_path(self) -> Path:
        """The policy bundle's folder, which a mission names relative to its own file, or by a bare name."""
        return policy_folder(self.mission.policy, self.path.parent)

    def place(self, key: str) -> str:
        """Return where the file has a key's value, "file:line:column"; the file alone where it does not have it."""
        mark = read_tree(self.source).values.get((key,))
        return f"{self.path}:{mark.line}:{mark.column}" if mark else str(self.path)


def load_mission(path: Path | str) -> MissionFile:
    """Read a mission file, and the files that it refers to.

    Raises:
        MissionError: there is no such file, it is not a mission, or something is wrong with a file that it refers to.
        InputError: the argument is not a path.
    """
    path = given_path("path", path, "a mission file")
    source = read_source(path, MissionError)
    return MissionFile(examine_mission(source, str(path), beside(path)).value(MissionError), source, path)


def parse_mission(source: bytes, where: str, files: Mapping[str, bytes] | None = None) -> Mission:
    """Read a mission from YAML text.

    Args:
        source: the text.
        where: names it in messages.
        files: the contents of the files that it refers to, by their names in it.

    Raises:
        MissionError: it is not a mission; everything wrong with it is listed with line and column.
    """
    return examine_mission(source, where, among(files or {})).value(MissionError)


def dump_mission(mission: Mission) -> str:
    """Return a mission as YAML that reads back as an equal mission; what is left to a default is left out."""
    from ruamel.yaml import YAML

    stream = io.StringIO()
    yaml = YAML()
    yaml.width = 2**20  # never fold a text
    content = mission.model_dump(exclude_defaults=True)
    if mission.link.preset is not None:
        content["link"] = mission.link.model_dump()  # a value left out would be the preset's, not the default
    yaml.dump(_for_yaml(content), stream)
    return stream.getvalue()


def mission_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 7) of a mission file, with every spelling that is read."""
    from waypointctl.mission.file_model import model_schema

    return {"$id": f"urn:waypointctl:mission:{SCHEMA_VERSION}", **model_schema(Mission, "waypointctl mission")}


def _for_yaml(value: Any) -> Any:
    """Return plain data for the YAML writer: text in quotes, since what it leaves bare may read as a number."""
    from ruamel.yaml.comments import CommentedSeq
    from ruamel.yaml.scalarstring import DoubleQuotedScalarString

    if isinstance(value, dict):
        return {key: _for_yaml(part) for key, part in value.items()}
    if isinstance(value, tuple):
        sequence = CommentedSeq(_for_yaml(part) for part in value)
        if all(isinstance(part, float) for part in value):
            sequence.fa.set_flow_style()
        return sequence
    return DoubleQuotedScalarString(value) if isinstance(value, str) else value
