"""The parts of a YAML text as written: scalars, mappings, lists, and the comments that belong to each entry."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final, TypeAlias

from ruamel.yaml import YAML
from ruamel.yaml.events import (
    CollectionEndEvent,
    CollectionStartEvent,
    Event,
    MappingStartEvent,
    NodeEvent,
    ScalarEvent,
)

_HEADER: Final = re.compile(r"([|>])([-+0-9]*)[ \t]*(#.*)?")


@dataclass(frozen=True, slots=True)
class Line:
    """A line of comment, and whether a blank one stands before it."""

    text: str
    blank_before: bool


@dataclass(slots=True)
class Scalar:
    """A value that is no collection.

    Attributes:
        text: as it is written, where that is in one line; else None.
        value: what it says.
        style: None for plain, or the character that it begins with.
        header_comment: behind the | or > of a block.
        start: where it begins in the whole text.
        end: where it ends.
    """

    text: str | None
    value: str
    style: str | None
    header_comment: str
    start: int
    end: int


@dataclass(slots=True)
class Collection:
    """A mapping or a list.

    Attributes:
        is_mapping: which of them.
        is_flow: whether it is written in braces or brackets.
        start: where it begins in the whole text.
        end: where it ends.
        column: where it begins in its line; of a list in block style, where the dashes stand.
        entries: in order.
    """

    is_mapping: bool
    is_flow: bool
    start: int
    column: int
    end: int = -1
    entries: list[Entry] = field(default_factory=list)


@dataclass(slots=True)
class Entry:
    """A key with its value, or an element of a list.

    Attributes:
        key: as it is written; None of a list's element.
        node: the value.
        start: where it begins in the whole text.
        column: where it begins in its line; of a list's element in block style, where its dash stands.
        holder: the collection that it is in.
        owner: the entry whose value that is; None at the root.
        leading: comments in lines before it.
        trailing: comments behind it, in its line.
        after: comments in lines after all of it.
        blank_before: whether a blank line stands before it.
    """

    key: str | None
    node: Node
    start: int
    column: int
    holder: Collection
    owner: Entry | None
    leading: list[Line] = field(default_factory=list)
    trailing: list[str] = field(default_factory=list)
    after: list[Line] = field(default_factory=list)
    blank_before: bool = False

    @property
    def has_comments(self) -> bool:
        """Whether any comment belongs to it or to what is in it."""
        inside = self.node.entries if isinstance(self.node, Collection) else ()
        return bool(self.leading or self.trailing or self.after) or any(entry.has_comments for entry in inside)


Node: TypeAlias = Scalar | Collection


def walk(node: Node) -> Iterator[Entry]:
    """Yield all entries in the order in which they are written."""
    if isinstance(node, Collection):
        for entry in node.entries:
            yield entry
            yield from walk(entry.node)


def read_nodes(text: str) -> Node:
    """Return the root of a YAML text that `read_tree` has read; lines end in a line feed alone."""
    reader = _Reader(text)
    for event in YAML(typ="safe", pure=True).parse(text):
        reader.take(event)
    assert reader.root is not None
    return reader.root


@dataclass(slots=True)
class _Open:
    """A collection that is being filled, and the entry whose value it is."""

    collection: Collection
    owner: Entry | None
    key: ScalarEvent | None = None


class _Reader:
    """Builds the nodes from the parser's events."""

    def __init__(self, text: str) -> None:
        self.root: Node | None = None
        self._text = text
        self._stack: list[_Open] = []

    def take(self, event: Event) -> None:
        if isinstance(event, CollectionEndEvent):
            self._stack.pop().collection.end = event.end_mark.index
        elif isinstance(event, CollectionStartEvent):
            mark = event.start_mark
            node = Collection(isinstance(event, MappingStartEvent), bool(event.flow_style), mark.index, mark.column)
            self._stack.append(_Open(node, self._place(node, event)))
        elif isinstance(event, ScalarEvent):
            opened = self._stack[-1] if self._stack else None
            if opened is not None and opened.collection.is_mapping and opened.key is None:
                opened.key = event
            else:
                self._place(self._scalar(event), event)

    def _place(self, node: Node, event: NodeEvent) -> Entry | None:
        if not self._stack:
            self.root = node
            return None
        opened = self._stack[-1]
        holder, key = opened.collection, opened.key
        mark = event.start_mark if key is None else key.start_mark
        column = mark.column if holder.is_mapping or holder.is_flow else holder.column
        text = None if key is None else self._text[key.start_mark.index : key.end_mark.index]
        entry = Entry(text, node, mark.index, column, holder, opened.owner)
        holder.entries.append(entry)
        opened.key = None
        return entry

    def _scalar(self, event: ScalarEvent) -> Scalar:
        start, end = event.start_mark.index, event.end_mark.index
        written, comment = self._text[start:end], ""
        if event.style in ("|", ">"):
            match = _HEADER.match(written)
            assert match is not None
            comment = (match.group(3) or "").rstrip()
        one_line = None if event.style in ("|", ">") or "\n" in written else written
        return Scalar(one_line, event.value, event.style, comment, start, end)
