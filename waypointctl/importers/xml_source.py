"""XML that others write, read with nothing that can execute, grow or fetch.

A document type declaration is refused: it is what declares entities, which can grow without bound ("billion laughs") or
name other files and hosts, and neither GPX nor KML has one. The parser is Python's own expat, whose handlers refuse it
before any entity is declared.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final
from xml.parsers import expat

from waypointctl.errors import MissionError
from waypointctl.importers.report import Report

_MOST_ELEMENTS: Final = 300_000
_MOST_DEPTH: Final = 100


@dataclass(slots=True)
class Element:
    """An element by its name without a namespace, with its place in the file."""

    name: str
    line: int
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)
    parts: list[str] = field(default_factory=list)

    @property
    def at(self) -> str:
        """Where it is, for messages."""
        return f"line {self.line} ({self.name})"

    @property
    def text(self) -> str:
        """Its own text, without the space around it."""
        return "".join(self.parts).strip()

    def each(self, *names: str) -> Iterator[Element]:
        """Yield the children of these names."""
        return (child for child in self.children if child.name in names)

    def text_of(self, name: str) -> str:
        """Return the text of the first child of a name, empty where there is none."""
        return next((child.text for child in self.each(name)), "")


def read_xml(source: bytes, report: Report) -> Element:
    """Return the root of an XML text.

    Raises:
        MissionError: it is not XML, or has a document type declaration, or is larger or deeper than is read.
    """
    builder = _Builder(report.where)
    try:
        builder.parser.Parse(source, True)
    except expat.ExpatError as error:
        problem = f"is not XML: {expat.errors.messages[error.code]}"
        raise MissionError(problem, where=f"{report.where}:{error.lineno}:{error.offset + 1}") from error
    except (LookupError, ValueError) as error:
        raise MissionError(f"is not XML that can be read: {error}", where=report.where) from error
    return builder.root


class _Builder:
    """Builds elements from what the parser finds."""

    def __init__(self, where: str) -> None:
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text
        self.parser.StartDoctypeDeclHandler = self._doctype
        self._where = where
        self._count = 0
        self._open: list[Element] = [Element("", 0, {})]

    @property
    def root(self) -> Element:
        return self._open[0].children[0]

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if self._count > _MOST_ELEMENTS:
            raise MissionError(f"has more than {_MOST_ELEMENTS:,} elements", where=self._where)
        if len(self._open) > _MOST_DEPTH:
            raise MissionError(f"has elements more than {_MOST_DEPTH} deep", where=self._where)
        element = Element(name.rpartition(":")[2], self.parser.CurrentLineNumber, attributes)
        self._open[-1].children.append(element)
        self._open.append(element)

    def _end(self, name: str) -> None:
        self._open.pop()

    def _text(self, data: str) -> None:
        self._open[-1].parts.append(data)

    def _doctype(self, *_: object) -> None:
        problem = "has a document type declaration (<!DOCTYPE ...>), which is not read: it can name other files"
        raise MissionError(problem, where=f"{self._where}:{self.parser.CurrentLineNumber}")
