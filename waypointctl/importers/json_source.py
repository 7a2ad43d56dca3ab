"""JSON that others write, each value with its place in the file."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

from waypointctl.display_text import counted, path_text, shown
from waypointctl.errors import MissionError
from waypointctl.importers.importer import Report, number_of

MOST_ENTRIES: Final = 20_000  # of a list that is gone through


@dataclass(frozen=True, slots=True)
class Part:
    """A value of a JSON file, with its place in it. What is not as it has to be is reported, and read as None."""

    value: Any
    path: tuple[str | int, ...]
    report: Report

    @property
    def at_text(self) -> str:
        """The place in the file, as "mission.items[3]"."""
        return path_text(self.path)

    def add_problem(self, problem: str, cause: str | None = None) -> None:
        """Report a problem here (see Report.add_problem)."""
        self.report.add_problem(self.at_text, problem, cause)

    def has(self, key: str) -> bool:
        """Tell whether there is something under a key."""
        return isinstance(self.value, dict) and self.value.get(key) is not None

    def get(self, key: str) -> Part | None:
        """Return the value of a key, None where it is missing."""
        return Part(self.value[key], (*self.path, key), self.report) if self.has(key) else None

    def at(self, key: str) -> Part | None:
        """Return the value of a key; a missing key, or a value that is not a mapping, is reported."""
        if not isinstance(self.value, dict):
            self.add_problem(f"{shown(self.value)} is not a mapping of keys to values", "not a mapping")
        elif not self.has(key):
            self.add_problem(f"'{key}' is missing")
        return self.get(key)

    def each(self, key: str, most: int = MOST_ENTRIES) -> Iterator[Part]:
        """Yield the elements of the list under a key, which may be left out."""
        part = self.at(key) if self.has(key) or not isinstance(self.value, dict) else None
        if part is not None:
            yield from part.elements(most)

    def elements(self, most: int = MOST_ENTRIES) -> Iterator[Part]:
        """Yield the elements of a list."""
        if not isinstance(self.value, list):
            self.add_problem(f"{shown(self.value)} is not a list", "not a list")
            return
        if len(self.value) > most:
            self.add_problem(f"has {len(self.value):,} entries; at most {most:,} are read", "too many entries")
            return
        for index, value in enumerate(self.value):
            yield Part(value, (*self.path, index), self.report)

    def number(self, low: float = -math.inf, high: float = math.inf) -> float | None:
        """Return a finite number within bounds."""
        number = None if isinstance(self.value, str) else number_of(self.value)
        if number is None:
            self.add_problem(f"{shown(self.value)} is not a finite number", "not a finite number")
        elif low <= number <= high:
            return number
        else:
            limits = f">= {low:g}" if high == math.inf else f"within {low:g} and {high:g}"
            self.add_problem(f"{shown(self.value)} is not a number {limits}", f"not {limits}")
        return None

    def whole(self) -> int | None:
        """Return a whole number, None for anything else."""
        number = None if isinstance(self.value, str) else number_of(self.value)
        return int(number) if number is not None and number.is_integer() else None

    def one_of(self, *allowed: object) -> bool:
        """Tell whether the value is one of these; another is reported. A whole float counts as its integer."""
        value = int(self.value) if isinstance(self.value, float) and self.value.is_integer() else self.value
        if any(type(each) is type(value) and each == value for each in allowed):
            return True
        self.add_problem(f"{shown(self.value)} is not {' or '.join(shown(each) for each in allowed)}")
        return False


def is_number(value: Any) -> bool:
    """Return whether a value is given: null and NaN mean that it is not."""
    return value is not None and not (isinstance(value, float) and math.isnan(value))


def is_unset(part: Part) -> bool:
    """Tell whether a list [latitude, longitude, ...] has neither."""
    return isinstance(part.value, list) and not any(map(is_number, part.value[:2]))


def place_in(part: Part) -> tuple[float, float] | None:
    """Return the place in a list [latitude, longitude, ...], None after reporting that there is none."""
    if not isinstance(part.value, list) or len(part.value) < 2:
        if isinstance(part.value, list):
            part.add_problem(f"has {counted(len(part.value), 'numbers')}; latitude and longitude are needed")
        else:
            part.add_problem(f"{shown(part.value)} is not a list", "not a list")
        return None
    return part.report.place(part.at_text, part.value[0], part.value[1])


def read_json(source: bytes, report: Report) -> Part:
    """Return the root of a JSON text. NaN is read as Python writes it.

    Raises:
        MissionError: it is not JSON.
    """
    where = report.where
    try:
        return Part(json.loads(source.decode("utf-8-sig")), (), report)
    except UnicodeDecodeError as error:
        raise MissionError(f"is not UTF-8 text: byte 0x{source[error.start]:02x}", where=where) from error
    except json.JSONDecodeError as error:
        several = error.msg == "Extra data"
        problem = "holds more than one JSON text" if several else f"is not JSON: {error.msg}"
        raise MissionError(problem, where=f"{where}:{error.lineno}:{error.colno}") from error
    except RecursionError as error:
        raise MissionError("is nested too deep to be read", where=where) from error
    except ValueError as error:  # an integer of thousands of digits
        raise MissionError("is not JSON that can be read: a number in it is too long", where=where) from error
