"""Read JSON that others write, and say of everything wrong with it where it stands."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn

from waypointctl.display_text import printable
from waypointctl.errors import MissionError
from waypointctl.mission.wording import path_text, shown
from waypointctl.mission.yaml_source import read_source


@dataclass(slots=True)
class JsonReport:
    """What is wrong with a file, in the order in which it is found, and what of it was left out on purpose."""

    where: str
    problems: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def refuse(self) -> None:
        """Refuse the file if anything is wrong with it.

        Raises:
            MissionError: with all of it.
        """
        if not self.problems:
            return
        if len(self.problems) == 1:
            raise MissionError(self.problems[0], where=self.where)
        details = [f"{printable(self.where)}: {problem}" for problem in self.problems]
        raise MissionError(f"{len(self.problems)} problems", where=self.where, details=details)


@dataclass(frozen=True, slots=True)
class Part:
    """A value of a JSON file, with its place in it. What is not as it has to be is reported, and read as None."""

    value: Any
    path: tuple[str | int, ...]
    report: JsonReport

    def complain(self, problem: str) -> None:
        """Report a problem here."""
        place = path_text(self.path)
        text = f"{place}: {problem}" if place else problem
        if text not in self.report.problems:  # one value may be looked at for several reasons
            self.report.problems.append(text)

    def note(self, text: str) -> None:
        """Note what is left out here."""
        self.report.notes.append(f"{path_text(self.path)}: {text}")

    def has(self, key: str) -> bool:
        """Tell whether there is something under a key."""
        return isinstance(self.value, dict) and self.value.get(key) is not None

    def at(self, key: str) -> Part | None:
        """Return what is under a key; that there is nothing, or that this is no mapping, is reported."""
        if not isinstance(self.value, dict):
            self.complain(f"{shown(self.value)} is not a mapping of keys to values")
            return None
        if self.value.get(key) is None:
            self.complain(f"'{key}' is missing")
            return None
        return Part(self.value[key], (*self.path, key), self.report)

    def each(self, key: str) -> Iterator[Part]:
        """Yield the elements of the list under a key, which may be left out."""
        part = self.at(key) if self.has(key) or not isinstance(self.value, dict) else None
        if part is not None:
            yield from part.elements()

    def elements(self) -> Iterator[Part]:
        """Yield the elements of a list."""
        if not isinstance(self.value, list):
            self.complain(f"{shown(self.value)} is not a list")
            return
        for index, value in enumerate(self.value):
            yield Part(value, (*self.path, index), self.report)

    def number(self, low: float = -math.inf, high: float = math.inf) -> float | None:
        """Return a finite number within bounds."""
        value = self.value
        if isinstance(value, bool) or not isinstance(value, int | float) or not _is_finite(value):
            self.complain(f"{shown(value)} is not a finite number")
            return None
        if not low <= value <= high:
            self.complain(f"{shown(value)} is not a number {_bounds(low, high)}")
            return None
        return float(value)

    def one_of(self, *allowed: object) -> bool:
        """Tell whether the value is one of these; that it is none is reported."""
        if any(type(each) is type(self.value) and each == self.value for each in allowed):
            return True
        self.complain(f"{shown(self.value)} is not {' or '.join(shown(each) for each in allowed)}")
        return False


def read_json(path: Path) -> Part:
    """Return the root of a JSON file.

    Raises:
        MissionError: there is no such file, or it is not JSON.
    """
    where = str(path)
    source = read_source(path, MissionError)
    try:
        value = json.loads(source.decode("utf-8-sig"), parse_constant=_no_constant)
    except UnicodeDecodeError as error:
        raise MissionError(f"is not UTF-8 text: byte 0x{source[error.start]:02x}", where=where) from error
    except json.JSONDecodeError as error:
        raise MissionError(f"is not JSON: {error.msg}", where=f"{where}:{error.lineno}:{error.colno}") from error
    except (RecursionError, ValueError) as error:
        raise MissionError("is not JSON that can be read: nested too deep, or with NaN in it", where=where) from error
    return Part(value, (), JsonReport(where))


def _is_finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer beyond all floats
        return False


def _bounds(low: float, high: float) -> str:
    return f">= {low:g}" if high == math.inf else f"within {low:g} and {high:g}"


def _no_constant(name: str) -> NoReturn:
    raise ValueError(name)
