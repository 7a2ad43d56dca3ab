"""Claims on delay, tested with a study's flights: each holds, is refuted, or was not measured."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict

from waypointctl.studies.case import JOINT, MISSION, SHORT_RANGE_GOAL, WAYPOINT
from waypointctl.studies.flights import Cell, DelayFlight, slope

Finding: TypeAlias = Literal["holds", "refuted", "not measured"]

ALLOWED: Final = 0.05  # relative to the formula
SLOWER: Final = 2.5
NEAR_S: Final = 0.4  # a round trip that is hardly noticed
MOON_S: Final = 2.56
QUARTER_S: Final = 0.25
FEWEST: Final = 5  # flights of a cell; with fewer chance would decide
UNMEASURED: Final = "not measured"

_CLAIMS: Final = {
    MISSION.name: "mission takes at most the zero-delay time plus one round trip, and 5 %",
    WAYPOINT.name: "waypoint takes one round trip more for each command waited for, within 5 %",
    SHORT_RANGE_GOAL.name: f"short_range_goal, move and wait, is at least {SLOWER:g} times slower at {MOON_S:g} s "
    f"than at {NEAR_S:g} s",
    JOINT.name: f"joint: more than half of the flights fail at some round trip below {QUARTER_S:g} s",
}


class ClaimResult(BaseModel):
    """A claim, on one route, and what the flights show."""

    model_config = ConfigDict(frozen=True)

    claim: str
    route: str
    finding: Finding
    found: str  # in figures


class JointLimit(BaseModel):
    """The round trips [s] between which `joint` ceases to succeed mostly, on one route."""

    model_config = ConfigDict(frozen=True)

    route: str
    mostly_succeeds_s: float | None  # the longest one before; None where there is none
    mostly_fails_s: float | None  # the shortest one at which less than half of the flights succeed; None for none


def assess_claims(cells: Sequence[Cell], flown: Sequence[DelayFlight]) -> tuple[ClaimResult, ...]:
    """Return each claim on each route, tested, of the autonomies that were flown.

    Args:
        cells: of all flights.
        flown: the flights.
    """
    found = []
    for autonomy, judge in ((MISSION, _mission), (SHORT_RANGE_GOAL, _short_range_goal), (JOINT, _joint)):
        for route, own in _by_route(cells, autonomy.name).items():
            finding, text = judge(own)
            found.append(ClaimResult(claim=_CLAIMS[autonomy.name], route=route, finding=finding, found=text))
    for route in _by_route(cells, WAYPOINT.name):
        finding, text = _waypoint([one for one in flown if (one.route, one.autonomy) == (route, WAYPOINT.name)])
        found.append(ClaimResult(claim=_CLAIMS[WAYPOINT.name], route=route, finding=finding, found=text))
    return tuple(sorted(found, key=lambda tested: list(_CLAIMS.values()).index(tested.claim)))


def joint_limits(cells: Sequence[Cell]) -> tuple[JointLimit, ...]:
    """Return for each route that `joint` was flown on where it fails."""
    return tuple(_limit(route, own) for route, own in _by_route(cells, JOINT.name).items())


def _by_route(cells: Sequence[Cell], autonomy: str) -> dict[str, list[Cell]]:
    """Return the cells of an autonomy by route, by round trip within it."""
    groups: dict[str, list[Cell]] = {}
    for cell in cells:
        if cell.autonomy == autonomy:
            groups.setdefault(cell.route, []).append(cell)
    return {route: sorted(own, key=lambda cell: cell.rtt_s) for route, own in groups.items()}


def _mission(cells: list[Cell]) -> tuple[Finding, str]:
    zero, *delayed = cells
    if zero.rtt_s or zero.time_s is None or not delayed:
        return UNMEASURED, "needs successes without a delay, and another round trip"
    if none := [cell for cell in delayed if cell.time_s is None]:
        return "refuted", f"no success at {none[0].rtt_s:g} s"
    base_s = zero.time_s.value
    shares = {cell: cell.time_s.value / (base_s + cell.rtt_s) for cell in delayed if cell.time_s is not None}
    worst = max(shares, key=lambda cell: shares[cell])
    text = (
        f"at most {shares[worst] - 1:+.1%}, at {worst.rtt_s:g} s: {worst.time_s} s against {base_s + worst.rtt_s:.2f} s"
    )
    return ("holds" if shares[worst] <= 1 + ALLOWED else "refuted"), text


def _waypoint(flown: list[DelayFlight]) -> tuple[Finding, str]:
    won = [one for one in flown if one.succeeded]
    if len({one.rtt_s for one in won}) < 2:
        return UNMEASURED, "needs successes at two round trips"
    found = slope([one.rtt_s for one in won], [one.time_s for one in won])
    waited = sum(one.exchanges for one in won) / len(won)
    text = f"{found} s a second of round trip, {waited:g} command{'s' * (waited != 1)} waited for"
    return ("holds" if abs(found.value - waited) <= ALLOWED * waited else "refuted"), text


def _short_range_goal(cells: list[Cell]) -> tuple[Finding, str]:
    near = {cell.rtt_s: cell.time_s.value for cell in cells if cell.rtt_s <= NEAR_S and cell.time_s is not None}
    moon = next((cell for cell in cells if cell.rtt_s == MOON_S), None)
    if moon is None or not near:
        return UNMEASURED, f"needs {MOON_S:g} s, and successes at {NEAR_S:g} s or below"
    if moon.time_s is None:
        return "refuted", f"no success at {MOON_S:g} s"
    ratios = {rtt_s: moon.time_s.value / time_s for rtt_s, time_s in near.items()}
    texts = (f"{ratio:.2f} times as long as at {rtt_s:g} s" for rtt_s, ratio in ratios.items())
    return ("holds" if min(ratios.values()) >= SLOWER else "refuted"), f"{moon.time_s} s, {' and '.join(texts)}"


def _joint(cells: list[Cell]) -> tuple[Finding, str]:
    zero, limit = cells[0], _limit(cells[0].route, cells)
    if zero.rtt_s == 0 and not zero.mostly_succeeds:
        return "refuted", f"it fails without a delay: {zero.successes} of {zero.flights}"
    if not any(0 < cell.rtt_s <= QUARTER_S for cell in cells):
        return UNMEASURED, "needs round trips between 0 s and 0.25 s: --find-joint-limit"
    texts = {cell.rtt_s: f"{cell.successes} of {cell.flights} succeed at {cell.rtt_s:g} s" for cell in cells}
    ends = (limit.mostly_succeeds_s, limit.mostly_fails_s)
    text = ", ".join(texts[rtt_s] for rtt_s in ends if rtt_s is not None)
    return ("holds" if ends[1] is not None and ends[1] <= QUARTER_S else "refuted"), text


def _limit(route: str, cells: list[Cell]) -> JointLimit:
    fails_s = next((cell.rtt_s for cell in cells if not cell.mostly_succeeds), None)
    before = [cell.rtt_s for cell in cells if fails_s is None or cell.rtt_s < fails_s]
    return JointLimit(route=route, mostly_succeeds_s=max(before, default=None), mostly_fails_s=fails_s)
