"""Evaluations as files: beside the policy that they are of, or where they were asked for."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from waypointctl.errors import OutputError
from waypointctl.evaluation.result import Evaluation, evaluations_json

PATTERN: Final = "evaluation*.json"
_PAPER: Final = "paper"
_FILE_MEND: Final = "give a file in a folder that you can write to"


def write_evaluation(evaluation: Evaluation, path: Path) -> None:
    """Write the evaluation as JSON.

    Raises:
        OutputError: the file cannot be written.
    """
    write_evaluations([evaluation], path)


def write_evaluations(evaluations: Sequence[Evaluation], path: Path) -> None:
    """Write one evaluation as it is, several as {"evaluations": [...]}; what stands at `path` is never half of it.

    Raises:
        OutputError: the file cannot be written.
    """
    place(path, evaluations_json(evaluations).encode(), "the evaluation")


def place(path: Path, content: bytes, what: str) -> None:
    """Write a file so that it appears whole; `what` it is goes into the message: "the picture".

    Raises:
        OutputError: the file cannot be written.
    """
    part = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        if path.exists() and not path.is_file():  # such as /dev/stdout
            path.write_bytes(content)
            return
        part.write_bytes(content)
        part.replace(path)
    except OSError as error:
        part.unlink(missing_ok=True)
        problem = f"{what} cannot be written: {error.strerror}"
        raise OutputError(problem, where=str(path), mend=_FILE_MEND) from error
