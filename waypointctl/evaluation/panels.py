"""What the picture of evaluations shows: which trials of which policy, panel by panel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.evaluation.paper_tables import entrants
from waypointctl.evaluation.result import Evaluation, names_of
from waypointctl.evaluation.rollout import Rollouts
from waypointctl.evaluation.suite import Suite, SuiteCase

FloatArray: TypeAlias = NDArray[np.float64]
End: TypeAlias = Literal["success", "fall", "time-out", "strayed"]

MOST_PANELS: Final = 48
_SHOWN: Final = 100  # trials of given paths in a panel, at least _LEAST of each
_LEAST: Final = 10
_WAYPOINTS: Final = 60  # of drawn paths in a panel: with more, they cannot be distinguished


@dataclass(frozen=True, slots=True)
class Trial:
    """One trial: its waypoints (m, 2) [m], the trajectory (k, 2) [m] of the robot, and how it ended."""

    path: FloatArray
    trajectory: FloatArray
    end: End


@dataclass(frozen=True, slots=True)
class Panel:
    """A panel of the picture."""

    title: str  # whose trials they are
    subtitle: str  # how many there were, how many succeeded, and how many are shown where that is not all
    group: str  # panels of one group are drawn to one scale
    given: tuple[FloatArray, ...]  # the paths (m, 2) [m] of all trials; none where each had its own
    trials: tuple[Trial, ...]  # those that are shown
    is_sample: bool = False  # there were more


def refuse_too_many(suite: Suite, num_policies: int) -> None:
    """Refuse a picture with too many panels, before the policies are evaluated.

    Raises:
        InputError: there would be more panels than a picture can hold.
    """
    count = len(suite.tables if _by_table(suite, num_policies) else suite.all_cases) * num_policies
    if count > MOST_PANELS:
        problem = f"--plot would have {count} panels, one for each case and policy; a picture holds {MOST_PANELS}"
        raise InputError(problem, hint="evaluate fewer policies at a time, or a suite of fewer cases")


def panels(
    suite: Suite,
    evaluations: Sequence[Evaluation],
    rollouts: Sequence[Mapping[str, Rollouts]],
    names: Sequence[str] | None = None,
) -> list[Panel]:
    """Return a panel for each table and policy, of a suite without tables or one policy for each case and policy.

    One policy is shown in all cases, as its table lists them: the suite's tables may have it in some of them alone.
    The rollouts are of each policy, by case. Without `names` policies are called as `names_of` has it.
    """
    names = names_of(evaluations) if names is None else names
    by_name = dict(zip(names, rollouts, strict=True))
    if _by_table(suite, len(evaluations)):
        return [
            _panel(suite, name, table.title, [case for case in suite.cases if case.name in table.cases], by_name[name])
            for table in suite.tables
            for name, _ in entrants(suite, table, evaluations, names)
        ]
    return [_panel(suite, name, case.name, [case], by_name[name]) for case in suite.all_cases for name in names]


def _by_table(suite: Suite, num_policies: int) -> bool:
    return bool(suite.tables) and num_policies > 1


def _panel(
    suite: Suite, policy: str, group: str, cases: Sequence[SuiteCase], rollouts: Mapping[str, Rollouts]
) -> Panel:
    given = suite.cases and all(case in suite.cases for case in cases)
    each = max(_LEAST, _SHOWN // len(cases)) if given else max(1, _WAYPOINTS // cases[0].longest)
    trials = [trial for case in cases for trial in _sample(rollouts[case.name], each)]
    successes = sum(int(rollouts[case.name].success.sum()) for case in cases)
    total = sum(len(rollouts[case.name].success) for case in cases)
    drawn = f", drawn {len(trials)}/{total}" if len(trials) < total else ""
    return Panel(
        title=policy,
        subtitle=f"{group}: success {successes}/{total}{drawn}",
        group=group,
        given=tuple(rollouts[case.name].paths[0] for case in cases) if given else (),
        trials=tuple(trials),
        is_sample=len(trials) < total,
    )


def _sample(rollouts: Rollouts, count: int) -> list[Trial]:
    """Return the first trials, and the first of those that failed: falls are rare, and of most interest."""
    traced = np.arange(len(rollouts.trajectories))
    failed = traced[~rollouts.success[: len(traced)]]
    return [
        Trial(rollouts.paths[i], rollouts.trajectories[i], _end(rollouts, int(i)))
        for i in np.union1d(traced[:count], failed[:count]).astype(int)
    ]


def _end(rollouts: Rollouts, trial: int) -> End:
    ends: dict[End, NDArray[np.bool_]] = {
        "success": rollouts.success,
        "fall": rollouts.fell,
        "time-out": rollouts.timed_out,
    }
    return next((end for end, flags in ends.items() if flags[trial]), "strayed")
