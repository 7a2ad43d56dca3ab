"""Evaluating policies by their folders, on a suite by its name or file; and the files that are written of it."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import typer
from pydantic import ValidationError

from waypointctl.display_text import printable
from waypointctl.errors import InputError, OutputError
from waypointctl.evaluation.evaluate import Progress, evaluate
from waypointctl.evaluation.grid import markdown_file
from waypointctl.evaluation.panels import panels, refuse_too_many
from waypointctl.evaluation.result import Evaluation, names_of
from waypointctl.evaluation.rollout import Rollouts
from waypointctl.evaluation.saved import (
    refuse_fewer_trials,
    refuse_other_files,
    refuse_unsavable,
    saved_name,
    write_evaluations,
)
from waypointctl.evaluation.suite import Suite, SuiteCase, load_suite
from waypointctl.evaluation.tables import MARKDOWN_HEAD, tables, title
from waypointctl.mission.fields import Acceptance
from waypointctl.mission.policy_name import is_installed
from waypointctl.paths import PNG, refuse_other_content, refuse_unwritable_file, write_whole
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import SelectionRecord
from waypointctl.robots.load import kept_robot
from waypointctl.task.plugins import load_plugins
from waypointctl.training.recipe_file import trained_on
from waypointctl.units import NUMBER_PATTERN

Loaded = Sequence[tuple[Path, LoadedPolicy]]  # each with its folder


@dataclass(frozen=True, slots=True)
class Evaluated:
    """A policy's folder, what its evaluation found, and the trials by case."""

    folder: Path
    evaluation: Evaluation
    rollouts: Mapping[str, Rollouts]


@dataclass(frozen=True, slots=True)
class ChosenSuite:
    """A suite, and the suite that policies are evaluated on: with another acceptance region, maybe."""

    given: str  # the given name or file
    own: Suite  # as it is
    used: Suite  # as the policies are to be evaluated on it

    @property
    def other_acceptance(self) -> Acceptance | None:
        """The region that takes the place of the suite's own, None where it is the suite's."""
        return None if self.own.acceptance == self.used.acceptance else self.used.acceptance


def chosen_suite(name_or_file: str, acceptance: str | None) -> ChosenSuite:
    """Return a suite, with the acceptance "SHAPE:SIZE" in place of its own if there is one."""
    own = load_suite(name_or_file)
    used = own if acceptance is None else own.accepting(_acceptance(acceptance))
    return ChosenSuite(name_or_file, own, used)


def _acceptance(text: str) -> Acceptance:
    """Read an acceptance region as a command line has it: "radius:0.2", "box:0.5" or "box:50cm"; a bare number is in m.

    Raises:
        InputError: it is none.
    """
    shape, _, size = text.partition(":")
    spelling = "size_m" if re.fullmatch(NUMBER_PATTERN, size.strip()) else "size"
    try:
        value = float(size) if spelling == "size_m" else size
        return Acceptance.model_validate({"shape": shape.strip(), spelling: value})
    except ValidationError as error:
        problem = f"{text!r} is not an acceptance region: a shape, box or radius, and a size up to 100 m"
        raise InputError(problem, where="--acceptance", hint="such as radius:0.2 or box:50cm") from error


def evaluate_loaded(
    loaded: Loaded,
    suite: ChosenSuite,
    trials: int | None,
    seed: int,
    threads: int = 0,
    progress: Progress | None = None,
    plugins: Sequence[Path] = (),
) -> list[Evaluated]:
    """Evaluate policies one after the other, each with the robot in its folder where the suite names none.

    Args:
        loaded: the policies; what each was trained on is read from the recipe in its folder.
        suite: the paths.
        trials: of each case; None: the suite's number.
        seed: of the starts and of random paths.
        threads: of the physics; 0 is one a core, 8 at most.
        progress: called with the progress of each policy.
        plugins: Python files, which are executed.
    """
    own = None if suite.other_acceptance is None else suite.own.acceptance
    found, executed = [], load_plugins(plugins)
    for folder, policy in loaded:
        rollouts: dict[str, Rollouts] = {}
        evaluation = evaluate(
            policy,
            suite.used,
            trials,
            seed,
            threads,
            progress,
            on_case=partial(_keep, rollouts),
            plugins=executed,
            robot=suite.used.robot or kept_robot(folder),
        )
        facts = {"suite_acceptance": own, "training": trained_on(folder, policy.manifest)}
        found.append(Evaluated(folder, evaluation.model_copy(update=facts), rollouts))
    return found


def _keep(kept: dict[str, Rollouts], case: SuiteCase, rollouts: Rollouts) -> None:
    kept[case.name] = rollouts


def refuse_selection_trials(loaded: Loaded, suite: ChosenSuite, seed: int, *, save: bool) -> None:
    """Refuse to save an evaluation in the trials that a policy was selected by; warn of one that is not saved."""
    for folder, policy in loaded:
        record = policy.manifest.training.selection
        if record is None or record.seed != seed or not _is_suite_of(record, suite):
            continue
        problem = (
            f"policy {policy.manifest.name!r} was selected by its success in these trials (suite {record.suite!r}, "
            f"seed {seed}), so its rate here is too high"
        )
        if save:
            hint = "Give another --seed; without --save there is a warning."
            raise InputError(f"--save: {problem}", where=str(folder), hint=hint)
        typer.echo(f"warning: {printable(folder)}: {printable(problem)}; give another --seed", err=True)


def _is_suite_of(record: SelectionRecord, suite: ChosenSuite) -> bool:
    """Return whether a selection was by this suite; of a file it has the path that its recipe gave."""
    recorded = Path(record.suite)
    return suite.own.name in (record.suite, recorded.stem) or recorded.name == Path(suite.given).name


@dataclass(frozen=True, slots=True)
class EvaluationFiles:
    """The output files: refused before the work, written after it."""

    folders: tuple[Path, ...]  # of the policies
    suite: ChosenSuite  # that is evaluated
    out: Path | None = None  # for the JSON
    markdown: Path | None = None  # for the tables
    plot: Path | None = None  # for the picture
    save: bool = False  # write each evaluation into its policy's folder
    force: bool = False  # replace files of another kind, and saved evaluations with more trials
    trials: int | None = None  # of each case; None: the suite's number

    def refuse_unwritable(self) -> None:
        """Refuse what could not be written, would replace something else, or could not be named or drawn."""
        if self.save:
            refuse_unsavable(self.suite.own)
            for folder in filter(is_installed, self.folders):
                problem = "--save writes into the policy's folder, and this one is part of the installed waypointctl"
                raise OutputError(problem, where=str(folder), hint="--out FILE writes the evaluation elsewhere")
        saved = [folder / self._saved_name for folder in self.folders] if self.save else []
        for path in [*([] if self.out is None else [self.out]), *saved]:
            refuse_unwritable_file(path, "the evaluation")
            if not self.force:
                refuse_other_files(path)
                if path in saved:
                    refuse_fewer_trials(path, self.trials or self.suite.own.trials)
        if self.plot is not None:
            refuse_too_many(self.suite.own, len(self.folders))
        self._refuse_other(self.markdown, "the table", MARKDOWN_HEAD.encode(), "a table of waypointctl's")
        self._refuse_other(self.plot, "the picture", PNG, "a PNG")
        taken = {os.path.realpath(path): "--save" for path in saved}
        for option, given in {"--out": self.out, "--markdown": self.markdown, "--plot": self.plot}.items():
            if given is None:
                continue
            other = taken.setdefault(os.path.realpath(given), option)
            if other != option:
                problem = f"{other} and {option} would both write this file"
                raise OutputError(problem, where=str(given), hint=f"give {option} another file")

    def _refuse_other(self, path: Path | None, what: str, magic: bytes, kind: str) -> None:
        if path is not None:
            refuse_unwritable_file(path, what)
            if not self.force:
                refuse_other_content(path, magic, kind)

    def write(self, found: Sequence[Evaluated]) -> None:
        """Write the output files."""
        evaluations = [one.evaluation for one in found]
        names = names_of(evaluations, self.folders)
        if self.out is not None:
            write_evaluations(evaluations, self.out)
            _say_written(self.out)
        if self.save:
            for one in found:
                write_evaluations([one.evaluation], one.folder / self._saved_name)
                _say_written(one.folder / self._saved_name)
        if self.markdown is not None:
            text = markdown_file(MARKDOWN_HEAD, tables(self.suite.own, evaluations, names))
            write_whole(self.markdown, text.encode(), "the table")
            _say_written(self.markdown)
        if self.plot is not None:
            from waypointctl.evaluation.picture import draw

            drawn = panels(self.suite.own, evaluations, [one.rollouts for one in found], names)
            picture = draw(drawn, self.suite.used.acceptance, title(evaluations), self.suite.used.hold)
            write_whole(self.plot, picture, "the picture")
            _say_written(self.plot)

    @property
    def _saved_name(self) -> str:
        return saved_name(self.suite.own.name, self.suite.other_acceptance)


def _say_written(path: Path) -> None:
    typer.echo(f"written: {printable(path)}", err=True)
