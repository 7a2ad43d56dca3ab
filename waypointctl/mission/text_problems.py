"""Problems in the plain text files that a mission refers to, each with its line and column."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from waypointctl.mission.problems import Problem

_WORD: Final = re.compile(r"\S+")


@dataclass(frozen=True, slots=True)
class Word:
    """A word of a line, with its place."""

    text: str
    line: int  # from 1
    column: int  # from 1


@dataclass(slots=True)
class TextReport:
    """What is found wrong with a text file, in the order in which it is found."""

    where: str  # the file
    problems: list[Problem] = field(default_factory=list)

    def add(self, at: Word | None, text: str) -> None:
        """Note a problem at a word, or with the file as a whole: at its beginning."""
        line, column = (at.line, at.column) if at else (1, 1)
        self.problems.append(Problem(self.where, line, column, "", text))

    def lines(self, source: bytes) -> Iterator[list[Word]]:
        """Yield the words of each line that has some; what follows a '#' is for people."""
        try:
            text = source.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            line = source.count(b"\n", 0, error.start) + 1
            column = error.start - source.rfind(b"\n", 0, error.start)
            self.add(Word("", line, column), f"is not UTF-8 text: byte 0x{source[error.start]:02x}")
            return
        for number, each in enumerate(text.split("\n"), 1):
            words = [Word(match.group(), number, match.start() + 1) for match in _WORD.finditer(each.partition("#")[0])]
            if words:
                yield words
