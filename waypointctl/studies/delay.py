"""The delay study: round trips by autonomies by routes, and what came of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from pydantic import BaseModel, ConfigDict, ValidationError

from waypointctl.errors import InputError
from waypointctl.input_file import RECORD_FILE, read_input
from waypointctl.mission.files import MissionFile
from waypointctl.studies.autonomy import JOINT, MISSION
from waypointctl.studies.case import FINE_RTTS_S, Case, grid
from waypointctl.studies.cell import Cell, cells_of
from waypointctl.studies.measure import Flown
from waypointctl.studies.results_file import Conditions
from waypointctl.studies.verdict import JointLimit, Verdict, joint_limits, verdicts

RTTS_S: Final = (0.0, 0.4, 2.56, 5.0, 10.0, 40.0)


class Route(BaseModel):
    """What a table says of a route."""

    model_config = ConfigDict(frozen=True)

    name: str
    waypoints: int
    length_m: float  # of the straight path
    think_s: float = 0.0  # how long the operator thinks on it


class DelayStudy(BaseModel):
    """What a delay study found; all that its tables and its picture show."""

    model_config = ConfigDict(frozen=True)

    policy: str
    policy_sha256: str
    source: str  # a hash of the code that flew
    think_s: float | None  # in place of the routes' own
    seeds: tuple[int, ...]
    routes: tuple[Route, ...]
    cells: tuple[Cell, ...]
    joint_sweep: tuple[Cell, ...]  # `joint` at the finer round trips, where it was asked for
    joint_limits: tuple[JointLimit, ...]
    verdicts: tuple[Verdict, ...]

    def cells_of(self, route: str, autonomy: str) -> tuple[Cell, ...]:
        """Return the cells of a line of the picture, by round trip; those of the finer sweep among them."""
        own = {
            cell.rtt_s: cell
            for cell in (*self.joint_sweep, *self.cells)
            if (cell.route, cell.autonomy) == (route, autonomy)
        }
        return tuple(own[rtt_s] for rtt_s in sorted(own))

    def walk_s(self, route: str) -> float | None:
        """Return how long a route takes without any delay, L/v [s]; None where that was not flown."""
        found = (cell.time_s for cell in self.cells_of(route, MISSION.name) if cell.rtt_s == 0)
        return next((time_s.value for time_s in found if time_s is not None), None)

    def predicted_s(self, route: str, autonomy: str, rtt_s: float) -> float | None:
        """Return T = L/v + N (RTT + think) [s] (W. R. Ferrell 1965), N as it was counted; None where there is none."""
        counts = [cell.exchanges for cell in self.cells_of(route, autonomy) if cell.exchanges]
        walk_s = self.walk_s(route)
        if walk_s is None or not counts:
            return None
        think_s = next(one.think_s for one in self.routes if one.name == route)
        return walk_s + sum(counts) / len(counts) * (rtt_s + think_s)


def delay_cases(
    routes: Sequence[str],
    autonomies: Sequence[str],
    rtts_s: Sequence[float],
    seeds: Sequence[int],
    *,
    find_joint_limit: bool = False,
) -> tuple[list[Case], list[Case]]:
    """Return the cases of the study and those of the finer sweep, in the order in which they are flown."""
    fine = grid(routes, [JOINT.name], FINE_RTTS_S, seeds) if find_joint_limit else []
    return grid(routes, autonomies, rtts_s, seeds), fine


def conclude(
    cases: Sequence[Case],
    fine: Sequence[Case],
    flown: Mapping[Case, Flown],
    routes: Mapping[str, MissionFile],
    conditions: Conditions,
) -> DelayStudy:
    """Return what the flights of `cases` and of the finer sweep found.

    Args:
        cases: of the study.
        fine: of the finer sweep.
        flown: at least those.
        routes: by name.
        conditions: under which they were flown.
    """
    cells, sweep = cells_of(cases, flown), cells_of(fine, flown)
    every = (*cells, *(cell for cell in sweep if cell not in cells))
    return DelayStudy(
        policy=conditions.policy,
        policy_sha256=conditions.policy_sha256,
        source=conditions.source,
        think_s=conditions.think_s,
        seeds=tuple(sorted({case.seed for case in cases})),
        routes=tuple(
            Route(
                name=name,
                waypoints=file.mission.num_legs,
                length_m=file.mission.path_length_m(),
                think_s=file.mission.operator.think_s if conditions.think_s is None else conditions.think_s,
            )
            for name, file in routes.items()
        ),
        cells=cells,
        joint_sweep=sweep,
        joint_limits=joint_limits(every),
        verdicts=verdicts(every, [flown[case] for case in cases if case in flown]),
    )


def read_study(path: Path) -> DelayStudy:
    """Read what a study found.

    Raises:
        InputError: the file cannot be read or is no such thing.
    """
    hint = "make it again with `waypointctl study delay`"
    content = read_input(path, RECORD_FILE, hint=hint)
    try:
        return DelayStudy.model_validate_json(content)
    except ValidationError as error:
        problem = f"not a delay study: {error.errors(include_url=False)[0]['msg']}"
        raise InputError(problem, where=str(path), hint=hint) from error
