"""Evaluations as files: in their policy's folder, or at a given path."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from pydantic import BaseModel, TypeAdapter, ValidationError

from waypointctl.errors import InputError, OutputError, SuiteError
from waypointctl.evaluation.result import EVALUATION, Evaluation, evaluations_json, read_evaluation
from waypointctl.evaluation.suite import BUILT_IN, Suite, load_suite
from waypointctl.input_file import RECORD_FILE, read_input
from waypointctl.mission.checks import file_name
from waypointctl.mission.fields import Acceptance
from waypointctl.paths import write_whole

PATTERN: Final = "evaluation*.json"  # names of evaluation files in a policy's folder

_PAPER: Final = "paper"


class _Several(BaseModel):
    evaluations: tuple[Evaluation, ...]


_EITHER: Final[TypeAdapter[Evaluation | _Several]] = TypeAdapter(Evaluation | _Several)


def write_evaluation(evaluation: Evaluation, path: Path) -> None:
    """Write the evaluation as JSON.

    Raises:
        OutputError: the file cannot be written.
    """
    write_evaluations([evaluation], path)


def write_evaluations(evaluations: Sequence[Evaluation], path: Path) -> None:
    """Write one evaluation as it is, several as {"evaluations": [...]}; the file appears whole.

    Raises:
        OutputError: the file cannot be written.
    """
    write_whole(path, evaluations_json(evaluations).encode(), "the evaluation")


def saved_name(suite: str, other_acceptance: Acceptance | None = None) -> str:
    """Return the name of an evaluation's file in its policy's folder.

    There is one for each suite, and one more for each acceptance region that is not the suite's own.
    """
    if other_acceptance is not None:
        return f"evaluation-{suite}-{other_acceptance.shape}-{other_acceptance.size_m:g}m.json"
    return EVALUATION if suite == _PAPER else f"evaluation-{suite}.json"


def remove_outdated(folder: Path, policy_sha256: str) -> None:
    """Remove an earlier policy's evaluations from a folder before another policy is written to it.

    evaluation.json goes in any case; those in other suites stay if they are of the very same policy.

    Raises:
        OutputError: one cannot be removed.
    """
    for path in folder.glob(PATTERN):
        try:
            if path.name == EVALUATION or _is_of_another(path, policy_sha256):
                path.unlink(missing_ok=True)
        except OSError as error:
            raise OutputError(f"cannot be replaced: {error.strerror}", where=str(path)) from error


def _is_of_another(path: Path, policy_sha256: str) -> bool:
    try:
        return read_evaluation(path).policy_sha256 != policy_sha256
    except InputError:
        return False  # not what --save wrote


def refuse_unsavable(suite: Suite) -> None:
    """Refuse a suite whose results would have the same file name as another suite's.

    Raises:
        SuiteError: its name cannot name a file, or is that of a suite that comes with waypointctl and is another.
    """
    try:
        file_name(suite.name)
    except ValueError as error:
        raise SuiteError(f"--save names a file after the suite, and {error}", hint="rename the suite") from error
    if suite.name in BUILT_IN and suite != load_suite(suite.name):
        problem = f"a suite that comes with waypointctl has the name {suite.name!r}"
        raise SuiteError(problem, hint="rename your suite, so that --save keeps the results of both")


def refuse_other_files(path: Path) -> None:
    """Refuse to replace a file unless it is an evaluation or empty.

    Raises:
        OutputError: it is something else.
    """
    if not path.is_file() or is_evaluations(read_input(path, RECORD_FILE, OutputError, hint="name another file")):
        return
    raise OutputError(
        "is there already and is not an evaluation", where=str(path), hint="--force replaces it; or name another file"
    )


def is_evaluations(text: bytes) -> bool:
    """Return whether a file's text is what `write_evaluations` writes, or nothing."""
    if not text.strip():
        return True
    try:
        _EITHER.validate_json(text)
    except ValidationError:
        return False
    return True
