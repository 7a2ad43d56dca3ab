"""YAML 1.2 text as plain data, with the line and column of everything in it.

Only the YAML that a file needs: one document of mappings, lists and scalars of the core schema. Aliases, tags and merge
keys are refused, so a small file cannot expand to a large one.
"""

from __future__ import annotations

import math
import re
import sys
from codecs import BOM_UTF8
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

from ruamel.yaml import YAML, events
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.reader import ReaderError

from waypointctl.mission.file_kind import FileKind, kind_of

MAX_DEPTH: Final = 20
MAX_BYTES: Final = 1 << 20

# Longer numbers are beyond every float; Python also refuses to print very long integers.
_MAX_DIGITS: Final = 400
_NAMED: Final[Mapping[str, float | bool | None]] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), math.nan),
    **dict.fromkeys((f"{sign}.{word}" for sign in ("", "+") for word in ("inf", "Inf", "INF")), math.inf),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), -math.inf),
}
_LONG_ESCAPE: Final = re.compile(r"\\U([0-9a-fA-F]{8})")
_INT: Final = re.compile(r"[-+]?[0-9]+")
_OCTAL_OR_HEX: Final = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT: Final = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")

DataPath: TypeAlias = tuple[str | int, ...]


@dataclass(frozen=True, slots=True)
class Mark:
    """A place in the text, both counted from 1."""

    line: int
    column: int


NOWHERE: Final = Mark(0, 0)


class YamlFault(Exception):
    """What makes a text unreadable, and where."""

    def __init__(self, text: str, mark: Mark = NOWHERE) -> None:
        """Keep what was found, and where if it is at one place."""
        super().__init__(text)
        self.text = text
        self.mark = mark


@dataclass(slots=True)
class Tree:
    """The data of a text, and the position of each part of it, by its path from the root."""

    data: Any = None
    values: dict[DataPath, Mark] = field(default_factory=dict)
    keys: dict[DataPath, Mark] = field(default_factory=dict)
    duplicates: list[tuple[DataPath, Mark]] = field(default_factory=list)


def read_tree(source: bytes) -> Tree:
    """Return the one document that `source` holds.

    A duplicate key keeps its first value and is listed in `duplicates`.

    Raises:
        YamlFault: it is empty, too large, not UTF-8, not YAML, more than one document, or nested too deep, or
            uses an alias, a tag or a key that is not text.
    """
    text = _decode(source)
    builder = _Builder()
    try:
        for event in YAML(typ="safe", pure=True).parse(text):
            builder.take(event)
    except MarkedYAMLError as error:
        raise _syntax_fault(error) from error
    except ReaderError as error:
        problem = f"has the control character #x{error.character:02x}"
        raise YamlFault(problem, _place_of(text, error.position)) from error
    except (YAMLError, ArithmeticError, ValueError, LookupError, AssertionError) as error:
        # The parser lets some malformed escapes and directives out as what they broke inside it.
        if fault := _escape_fault(text, builder.last_index):
            raise fault from error
        raise YamlFault(f"is not YAML: {_first_line(str(error))}", builder.last) from error
    if builder.tree.data is None:
        raise YamlFault("is empty", Mark(1, 1))
    return builder.tree


def plain(text: str) -> str | int | float | bool | None:
    """Return what a scalar without quotes means in YAML 1.2's core schema (section 10.3.2)."""
    if text in _NAMED:
        return _NAMED[text]
    if _INT.fullmatch(text):
        return int(text) if len(text) <= _MAX_DIGITS else float(text)
    if _OCTAL_OR_HEX.fullmatch(text):
        return int(text, 0) if len(text) <= _MAX_DIGITS else math.inf
    if _FLOAT.fullmatch(text):
        return float(text)
    return text


@dataclass(slots=True)
class _Frame:
    """A mapping or list that is being filled."""

    container: dict[str, Any] | list[Any]
    path: DataPath
    key: str | None = None  # of a mapping, read and waiting for its value


class _Builder:
    """Fills a tree from the parser's events, without recursion."""

    def __init__(self) -> None:
        self.tree = Tree()
        self.last, self.last_index = Mark(1, 1), 0
        self._stack: list[_Frame] = []
        self._documents = 0

    def take(self, event: events.Event) -> None:
        """Add one event's part to the tree."""
        self.last, self.last_index = _mark(event.start_mark), event.start_mark.index
        if isinstance(event, events.DocumentStartEvent):
            self._start_document(event)
        elif isinstance(event, events.AliasEvent):
            raise YamlFault(f"the alias *{event.anchor} is not allowed: write the value out", self.last)
        elif isinstance(event, events.CollectionEndEvent):
            self._stack.pop()
        elif isinstance(event, events.NodeEvent):
            self._take_node(event)

    def _start_document(self, event: events.DocumentStartEvent) -> None:
        self._documents += 1
        if self._documents > 1:
            raise YamlFault("a second document starts here; a file holds one", self.last)
        if event.version is not None and tuple(event.version) != (1, 2):
            raise YamlFault("only YAML 1.2 is read: remove the %YAML line", self.last)

    def _take_node(self, event: events.NodeEvent) -> None:
        if event.anchor is not None:
            raise YamlFault(f"the anchor &{event.anchor} is not allowed: write the value out", self.last)
        if isinstance(event, events.ScalarEvent | events.CollectionStartEvent) and event.tag is not None:
            raise YamlFault(f"the tag {event.tag} is not allowed: leave it out", self.last)
        if isinstance(event, events.ScalarEvent):
            if any("\ud800" <= character <= "\udfff" for character in event.value):
                raise YamlFault("half of a surrogate pair is not a character", self.last)
            if not self._is_key(event):
                self._place(plain(event.value) if event.implicit[0] else event.value)
        elif isinstance(event, events.MappingStartEvent):
            self._open({})
        elif isinstance(event, events.SequenceStartEvent):
            self._open([])

    def _is_key(self, event: events.ScalarEvent) -> bool:
        frame = self._stack[-1] if self._stack else None
        if frame is None or not isinstance(frame.container, dict) or frame.key is not None:
            return False
        frame.key = event.value
        path = (*frame.path, event.value)
        if event.value in frame.container:
            self.tree.duplicates.append((path, self.last))
        else:
            self.tree.keys.setdefault(path, self.last)
        return True

    def _open(self, container: dict[str, Any] | list[Any]) -> None:
        if len(self._stack) == MAX_DEPTH:
            raise YamlFault(f"is nested more than {MAX_DEPTH} levels deep", self.last)
        self._stack.append(_Frame(container, self._place(container)))

    def _place(self, value: Any) -> DataPath:
        """Put a value where the text has come to, and return its path."""
        if not self._stack:
            self.tree.data = value
            self.tree.values[()] = self.last
            return ()
        frame = self._stack[-1]
        if isinstance(frame.container, list):
            path = (*frame.path, len(frame.container))
            frame.container.append(value)
        elif frame.key is None:
            raise YamlFault("a mapping or list cannot be a key", self.last)
        else:
            path = (*frame.path, frame.key)
            frame.container.setdefault(frame.key, value)
            frame.key = None
        self.tree.values.setdefault(path, self.last)
        return path


def _decode(source: bytes) -> str:
    if len(source) > MAX_BYTES:
        raise YamlFault(f"has {len(source)} bytes; {MAX_BYTES} are allowed")
    kind = kind_of(source)
    if kind is not None and kind not in (FileKind.JSON, FileKind.HDTN_PLAN):  # other JSON is YAML too
        raise YamlFault(kind.value, Mark(1, 1))
    source = source.removeprefix(BOM_UTF8)
    try:
        text = source.decode()
    except UnicodeDecodeError as error:
        before = source[: error.start].decode()
        problem = f"is not UTF-8 text: byte 0x{source[error.start]:02x}"
        raise YamlFault(problem, _place_of(before, len(before))) from error
    if not text.strip():
        raise YamlFault("is empty", Mark(1, 1))
    return text


def _escape_fault(text: str, begin: int) -> YamlFault | None:
    r"""Return what is wrong with the first escape from `begin` on that is beyond \U0010FFFF, None if there is none."""
    for found in _LONG_ESCAPE.finditer(text, begin):
        if int(found[1], 16) > sys.maxunicode:
            place = _place_of(text, found.start())
            return YamlFault(f"{found[0]} is not a character: the last one is \\U{sys.maxunicode:08X}", place)
    return None


def _syntax_fault(error: MarkedYAMLError) -> YamlFault:
    mark = _mark(error.problem_mark or error.context_mark)
    if error.problem and "'\\t'" in error.problem:
        return YamlFault("is indented with a tab: YAML needs spaces", mark)
    found = ", ".join(part for part in (error.context, error.problem) if part)
    return YamlFault(f"is not YAML: {_first_line(found)}", mark)


def _mark(mark: Any) -> Mark:
    return NOWHERE if mark is None else Mark(mark.line + 1, mark.column + 1)


def _place_of(text: str, index: int) -> Mark:
    return Mark(text.count("\n", 0, index) + 1, index - text.rfind("\n", 0, index))


def _first_line(text: str) -> str:
    return text.strip().partition("\n")[0]
