"""Evaluating policies by their folders, on a suite by its name or file."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import typer
from pydantic import ValidationError

from waypointctl.display_text import printable
from waypointctl.errors import InputError
from waypointctl.evaluation.evaluate import Progress, evaluate
from waypointctl.evaluation.result import Evaluation
from waypointctl.evaluation.rollout import Rollouts
from waypointctl.evaluation.suite import Suite, SuiteCase, load_suite
from waypointctl.mission.fields import Acceptance
from waypointctl.policy.bundle import LoadedPolicy, load_policy
from waypointctl.policy.manifest import SelectionRecord
from waypointctl.robots.folder import kept_robot
from waypointctl.task.plugins import load_plugins
from waypointctl.training.recipe_file import trained_on
from waypointctl.units import NUMBER_PATTERN


@dataclass(frozen=True, slots=True)
class Evaluated:
    """A policy's folder, what its evaluation found, and the trials by case."""

    folder: Path
    evaluation: Evaluation
    rollouts: Mapping[str, Rollouts]


@dataclass(frozen=True, slots=True)
class ChosenSuite:
    """A suite, and the suite that policies are evaluated on: with another acceptance region, maybe.

    Attributes:
        given: the given name or file.
        own: as it is.
        used: as the policies are to be evaluated on it.
    """

    given: str
    own: Suite
    used: Suite

    @property
    def other_acceptance(self) -> Acceptance | None:
        """The region that takes the place of the suite's own, None where it is the suite's."""
        return None if self.own.acceptance == self.used.acceptance else self.used.acceptance


def chosen_suite(name_or_file: str, acceptance: str | None) -> ChosenSuite:
    """Return a suite, with the acceptance "SHAPE:SIZE" in place of its own if there is one.

    Raises:
        SuiteError: there is no such suite, or it is not one.
        InputError: the acceptance is none.
    """
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


def load_folders(folders: Sequence[Path]) -> list[tuple[Path, LoadedPolicy]]:
    """Load the policy in each folder.

    Raises:
        PolicyError: one is missing or damaged.
    """
    return [(folder, load_policy(folder)) for folder in folders]


def evaluate_loaded(
    loaded: Sequence[tuple[Path, LoadedPolicy]],
    suite: ChosenSuite,
    trials: int | None,
    seed: int,
    threads: int = 0,
    progress: Progress | None = None,
    plugins: Sequence[Path] = (),
) -> list[Evaluated]:
    """Evaluate policies one after the other, each with the robot in its folder where the suite names none.

    Args:
        loaded: each with its folder; what it was trained on is read from the recipe there.
        suite: the paths.
        trials: of each case; None: the suite's number.
        seed: of the starts and of random paths.
        threads: of the physics; 0 is one a core, 8 at most.
        progress: called with the progress of each policy.
        plugins: Python files, which are executed.

    Raises:
        PolicyError: a policy was made for something else.
    """
    own = None if suite.other_acceptance is None else suite.own.acceptance
    found, executed = [], load_plugins(plugins)
    for folder, policy in loaded:
        rollouts = _RolloutsByCase()
        evaluation = evaluate(
            policy,
            suite.used,
            trials,
            seed,
            threads,
            progress,
            on_case=rollouts.keep,
            plugins=executed,
            robot=suite.used.robot or kept_robot(folder),
        )
        facts = {"suite_acceptance": own, "training": trained_on(folder, policy.manifest)}
        found.append(Evaluated(folder, evaluation.model_copy(update=facts), rollouts.by_case))
    return found


class _RolloutsByCase:
    def __init__(self) -> None:
        self.by_case: dict[str, Rollouts] = {}

    def keep(self, case: SuiteCase, rollouts: Rollouts) -> None:
        self.by_case[case.name] = rollouts


def refuse_selection_trials(
    loaded: Sequence[tuple[Path, LoadedPolicy]], suite: ChosenSuite, seed: int, *, save: bool
) -> None:
    """Refuse to save an evaluation in the trials that a policy was selected by; warn of one that is not saved.

    Raises:
        InputError: one of the policies was chosen by them, and the evaluation is to be saved.
    """
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
