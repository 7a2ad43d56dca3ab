"""What the trials of one route, autonomy and round trip came to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from pydantic import BaseModel, ConfigDict

from waypointctl.evaluation.wilson import wilson_interval
from waypointctl.studies.case import Case
from waypointctl.studies.estimate import Estimate, mean
from waypointctl.studies.measure import Flown


class Cell(BaseModel):
    """The trials of a route, an autonomy and a round trip.

    Times and distances are those of the successes: a flight that failed did not come to where it should. None of them
    is there where no trial was one.
    """

    model_config = ConfigDict(frozen=True)

    route: str
    autonomy: str
    rtt_s: float
    flights: int
    successes: int
    rate: float
    wilson95: tuple[float, float]
    falls: int  # of all flights
    time_s: Estimate | None
    distance_m: Estimate | None
    standing_s: Estimate | None
    standing_share: Estimate | None  # of the time
    exchanges: float | None  # commands that the operator waited for, mean of a flight

    @property
    def mostly_succeeds(self) -> bool:
        """Whether at least half of the trials were successes."""
        return 2 * self.successes >= self.flights


def cells_of(cases: Iterable[Case], flown: Mapping[Case, Flown]) -> tuple[Cell, ...]:
    """Return a cell for each route, autonomy and round trip of `cases`, in their order, of those that were flown."""
    groups: dict[tuple[str, str, float], list[Flown]] = {}
    for case in cases:
        if case in flown:
            groups.setdefault((case.route, case.autonomy, case.rtt_s), []).append(flown[case])
    return tuple(_cell(group) for group in groups.values())


def _cell(group: list[Flown]) -> Cell:
    first, won = group[0], [one for one in group if one.succeeded]
    return Cell(
        route=first.route,
        autonomy=first.autonomy,
        rtt_s=first.rtt_s,
        flights=len(group),
        successes=len(won),
        rate=len(won) / len(group),
        wilson95=wilson_interval(len(won), len(group)),
        falls=sum(one.falls for one in group),
        time_s=mean([one.time_s for one in won]) if won else None,
        distance_m=mean([one.distance_m for one in won]) if won else None,
        standing_s=mean([one.standing_s for one in won]) if won else None,
        standing_share=mean([one.standing_s / one.time_s for one in won]) if won else None,
        exchanges=float(np.mean([one.exchanges for one in won])) if won else None,
    )
