"""The flights of a study as a file that grows: JSON Lines, the first of them what decides the flights.

A line is written whole or, by a process that is killed, not: what is left of a torn one is dropped when the file is
read again. So an interrupted study continues, and a finished one can be extended.
"""

from __future__ import annotations

import fcntl
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, Self, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from waypointctl.errors import InputError, OutputError
from waypointctl.input_file import read_input
from waypointctl.paths import open_lock, write_whole
from waypointctl.studies.case import DelayCase
from waypointctl.studies.flights import DelayFlight

RESULTS: Final = "flights.jsonl"

R = TypeVar("R", bound=BaseModel)

_LARGEST: Final = 2**28  # [bytes]
_WHAT: Final = "the results"
_MEND: Final = "Give another --out, or remove that file to start again."


class StudyInputs(BaseModel):
    """What decides how a case goes, beside the case itself."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    policy: str
    policy_sha256: str
    think_s: float | None  # in place of the routes' own
    source: str  # a hash of the code that flies
    routes: dict[str, str]  # SHA-256 of each route's file and of those that it refers to, by name

    def together_with(self, others: StudyInputs) -> StudyInputs:
        """Return the inputs of the flights of both studies.

        Raises:
            ValueError: a flight would not go with both as it does with one.
        """
        for field, what in (
            ("policy_sha256", "policy"),
            ("think_s", "think time"),
            ("source", "version of waypointctl"),
        ):
            if getattr(self, field) != getattr(others, field):
                raise ValueError(f"was made with another {what}")
        for name in self.routes.keys() & others.routes.keys():
            if self.routes[name] != others.routes[name]:
                raise ValueError(f"was made with another route {name!r}")
        return self.model_copy(update={"routes": dict(sorted({**others.routes, **self.routes}.items()))})


class ResultsFile:
    """The flights that have been flown with some inputs, in memory and on disk.

    Attributes:
        path: of the file.
        flown: by case.
    """

    def __init__(self, path: Path, inputs: StudyInputs) -> None:
        """Read what is there; a new file begins with the inputs.

        Raises:
            InputError: it holds the flights of another study, or something else.
            OutputError: it cannot be written.
        """
        self.path = path
        self.flown: dict[DelayCase, DelayFlight] = {}
        self._inputs = self._read(inputs) if path.exists() else inputs
        self.write_in_order(self.flown)

    @classmethod
    @contextmanager
    def held(cls, folder: Path, inputs: StudyInputs) -> Iterator[Self]:
        """Make the folder of a study, keep every other study out of it, and yield its results.

        Raises:
            InputError, OutputError: as above, or another study is at it.
        """
        try:
            folder.mkdir(parents=True, exist_ok=True)
            lock = open_lock(folder / ".lock")
        except OSError as error:
            raise OutputError(f"the study cannot be written: {error.strerror}", where=str(folder)) from error
        with lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # let go of when the process ends, however it does
            except BlockingIOError:
                raise OutputError(
                    "another study is writing here", where=str(folder), hint="Wait for its end."
                ) from None
            yield cls(folder / RESULTS, inputs)

    def add(self, flown: DelayFlight) -> None:
        """Write a flight down, at once and for good.

        Raises:
            OutputError: it cannot be written.
        """
        try:
            with self.path.open("ab", buffering=0) as file:
                file.write(_line(flown))
        except OSError as error:
            raise OutputError(f"{_WHAT} cannot be written: {error.strerror}", where=str(self.path)) from error
        self.flown[flown.case] = flown

    def write_in_order(self, cases: Iterable[DelayCase]) -> None:
        """Write the file again, the flights of `cases` first and in that order: as they end, they come in any.

        Raises:
            OutputError: it cannot be written; what was there before still is.
        """
        order = dict.fromkeys([*(case for case in cases if case in self.flown), *sorted(self.flown)])
        lines = [_line(self._inputs), *(_line(self.flown[case]) for case in order)]
        write_whole(self.path, b"".join(lines), _WHAT)

    def _read(self, inputs: StudyInputs) -> StudyInputs:
        """Take in the flights that are there; return the inputs of all."""
        content = read_input(self.path, _LARGEST, OutputError, within=self.path.parent, hint=_MEND)
        *lines, _ = content.split(b"\n")  # what follows the last line break is torn, or nothing
        if not lines:
            return inputs
        there = self._parsed(StudyInputs, lines[0], 1)
        for number, line in enumerate(lines[1:], 2):
            flown = self._parsed(DelayFlight, line, number)
            self.flown[flown.case] = flown
        try:
            return inputs.together_with(there)
        except ValueError as error:
            raise InputError(str(error), where=str(self.path), hint=_MEND) from error

    def _parsed(self, model: type[R], line: bytes, number: int) -> R:
        try:
            return model.model_validate_json(line)
        except ValidationError as error:
            problem = f"not the flights of a study: {error.errors(include_url=False)[0]['msg']}"
            raise InputError(problem, where=f"{self.path}:{number}", hint=_MEND) from error


def _line(record: BaseModel) -> bytes:
    return f"{record.model_dump_json()}\n".encode()
