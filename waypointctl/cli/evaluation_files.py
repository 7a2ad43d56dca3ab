"""The files that `waypointctl eval` writes: refused before the work, written after it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from waypointctl.cli.evaluation_run import ChosenSuite, Evaluated
from waypointctl.errors import OutputError
from waypointctl.evaluation.names import names_of
from waypointctl.evaluation.panels import panels, refuse_too_many
from waypointctl.evaluation.saved import (
    refuse_other_files,
    refuse_unsavable,
    saved_name,
    write_evaluation,
    write_evaluations,
)
from waypointctl.evaluation.tables import MARKDOWN_HEAD, tables, title, to_markdown
from waypointctl.mission.policy_name import is_installed
from waypointctl.paths import refuse_other_content, refuse_unwritable_file, write_whole

_PNG: Final = b"\x89PNG\r\n\x1a\n"


@dataclass(frozen=True, slots=True)
class EvaluationFiles:
    """The output files.

    Attributes:
        folders: of the policies.
        suite: that is evaluated.
        out: for the JSON.
        markdown: for the tables.
        plot: for the picture.
        save: write each evaluation into its policy's folder.
        force: replace files of another kind.
    """

    folders: tuple[Path, ...]
    suite: ChosenSuite
    out: Path | None = None
    markdown: Path | None = None
    plot: Path | None = None
    save: bool = False
    force: bool = False

    def refuse_unwritable(self) -> None:
        """Refuse what could not be written, or would take the place of something else.

        Raises:
            OutputError: a file cannot be written, or is there already and of another kind, or two would be one.
            InputError: the suite's results cannot be saved, or the picture would have too many panels.
        """
        if self.save:
            refuse_unsavable(self.suite.own)
            for folder in filter(is_installed, self.folders):
                problem = "--save writes into the policy's folder, and this one is part of the installed waypointctl"
                raise OutputError(problem, where=str(folder), hint="--out FILE writes the evaluation elsewhere")
        for path in self._evaluations():
            refuse_unwritable_file(path, "the evaluation")
            if not self.force:
                refuse_other_files(path)
        if self.markdown is not None:
            refuse_unwritable_file(self.markdown, "the table")
            if not self.force:
                refuse_other_content(self.markdown, MARKDOWN_HEAD.encode(), "a table of waypointctl's")
        if self.plot is not None:
            refuse_unwritable_file(self.plot, "the picture")
            refuse_too_many(self.suite.own, len(self.folders))
            if not self.force:
                refuse_other_content(self.plot, _PNG, "a PNG")
        self._refuse_one_for_two()

    def _refuse_one_for_two(self) -> None:
        given = {"--out": self.out, "--markdown": self.markdown, "--plot": self.plot}
        taken = {os.path.realpath(path): "--save" for path in self._saved()}
        for option, path in given.items():
            if path is None:
                continue
            other = taken.setdefault(os.path.realpath(path), option)
            if other != option:
                problem = f"{other} and {option} would both write this file"
                raise OutputError(problem, where=str(path), hint=f"give {option} another file")

    def write(self, found: Sequence[Evaluated]) -> None:
        """Write the output files.

        Raises:
            OutputError: a file cannot be written.
        """
        evaluations = [one.evaluation for one in found]
        if self.out is not None:
            write_evaluations(evaluations, self.out)
        if self.save:
            for one in found:
                write_evaluation(one.evaluation, one.folder / self._saved_name)
        if self.markdown is not None:
            text = to_markdown(tables(self.suite.own, evaluations, _names(found)))
            write_whole(self.markdown, text.encode(), "the table")
        if self.plot is not None:
            write_whole(self.plot, self.picture(found), "the picture")

    def picture(self, found: Sequence[Evaluated]) -> bytes:
        """Return the paths driven as PNG."""
        from waypointctl.evaluation.picture import draw

        evaluations = [one.evaluation for one in found]
        drawn = panels(self.suite.own, evaluations, [one.rollouts for one in found], _names(found))
        return draw(drawn, self.suite.used.acceptance, title(evaluations), self.suite.used.hold)

    def _evaluations(self) -> list[Path]:
        return [*([] if self.out is None else [self.out]), *self._saved()]

    def _saved(self) -> list[Path]:
        return [folder / self._saved_name for folder in self.folders] if self.save else []

    @property
    def _saved_name(self) -> str:
        return saved_name(self.suite.own.name, self.suite.other_acceptance)


def _names(found: Sequence[Evaluated]) -> list[str]:
    return names_of([one.evaluation for one in found], [one.folder for one in found])
