"""The plain text files that a mission refers to: words with their places, moments, and measured jitter.

A file of jitter has one number of seconds a line; what follows a '#' is a comment.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime
from typing import Final

from waypointctl.mission.file_kind import kind_of
from waypointctl.mission.problems import Problem

TIME_FORMAT: Final = "%Y/%m/%d-%H:%M:%S"  # an absolute time, as contact plans have it
ABSOLUTE: Final = re.compile(r"[0-9]{4}/[0-9]{1,2}/[0-9]{1,2}-[0-9]{1,2}:[0-9]{1,2}:[0-9]{1,2}")
ANY_MOMENT: Final = "0001/01/01-00:00:00"  # reference for checking each line, where the right one is not known
_WORD: Final = re.compile(r"\S+")

MOST_S: Final = 86_400.0


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


def moment_of(text: str) -> datetime | None:
    """Return an absolute time, None for any other text."""
    try:
        return datetime.strptime(text, TIME_FORMAT).replace(tzinfo=UTC) if ABSOLUTE.fullmatch(text) else None
    except ValueError:
        return None


def read_jitter(
    source: bytes, where: str, least_delay_s: float | None = None
) -> tuple[tuple[float, ...], tuple[Problem, ...]]:
    """Return the numbers [s] that a file holds, and everything that is wrong with it.

    Args:
        source: the file's bytes.
        where: its name, for the problems.
        least_delay_s: the shortest delay of the link that it is for; nothing may arrive before it has left. None where
            that is not known, or was looked at before.
    """
    if kind := kind_of(source):
        return (), (Problem(where, 0, 0, "", f"{kind.value}; a file of jitter has one number of seconds a line"),)
    report = TextReport(where)
    samples = []
    for word, *others in report.lines(source):
        value = _seconds(word, report, least_delay_s)
        if others:
            report.add(others[0], f"'{others[0].text}' follows the number; write one number of seconds a line")
        if value is not None:
            samples.append(value)
    if not samples and not report.problems:
        report.add(None, "holds no number; a file of jitter has one number of seconds a line")
    return tuple(samples), tuple(report.problems)


def _seconds(word: Word, report: TextReport, least_delay_s: float | None) -> float | None:
    try:
        value = float(word.text.replace("_", "?"))  # Python reads 1_0 as 10
    except ValueError:
        report.add(word, f"'{word.text}' is not a number of seconds")
        return None
    if not abs(value) <= MOST_S:
        report.add(word, f"{word.text} is not between -{MOST_S:g} and {MOST_S:g} s")
        return None
    if least_delay_s is not None and value < -least_delay_s:
        report.add(
            word,
            f"{word.text} s takes more off than the delay of {least_delay_s:g} s: nothing arrives before it is sent; "
            "numbers here are what is added to the delay",
        )
        return None
    return value
