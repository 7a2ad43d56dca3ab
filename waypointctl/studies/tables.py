"""What a delay study found, as tables and as comma-separated values."""

from __future__ import annotations

import csv
import io
from typing import Final

from waypointctl.evaluation.grid import Column, Grid, interval
from waypointctl.studies.case import JOINT
from waypointctl.studies.claims import FEWEST, UNMEASURED
from waypointctl.studies.delay import DelayStudy, Route
from waypointctl.studies.flights import Cell, Estimate

MARKDOWN_HEAD: Final = "<!-- waypointctl study delay -->\n"

_COLUMNS: Final = (
    Column("autonomy", is_text=True),
    Column("RTT [s]"),
    Column("success"),
    Column("95 % CI [%]", spare=3),
    Column("time [s]"),
    Column("distance [m]", spare=4),
    Column("standing [s]", spare=2),
    Column("standing"),
    Column("falls"),
    Column("waited for", spare=1),
)


def overview(study: DelayStudy, route: Route) -> Grid:
    """Return the mean times on a route at a glance: a row for each autonomy, a column for each round trip."""
    own = {(cell.autonomy, cell.rtt_s): cell for cell in study.cells if cell.route == route.name}
    rtts_s = sorted({rtt_s for _, rtt_s in own})
    names = dict.fromkeys(autonomy for autonomy, _ in own)
    rows = [(name, *(_time(own[name, rtt_s]) for rtt_s in rtts_s)) for name in names]
    columns = (Column("autonomy", is_text=True), *(Column(f"{rtt_s:g} s") for rtt_s in rtts_s))
    note = "Mean of the successes, in s, by round trip; *: not all succeeded."
    title = f"{route.name}: time until the operator knows, {_flown_by(study, route)}"
    return Grid(title, columns, tuple(rows), (note,))


def route_grid(study: DelayStudy, route: Route) -> Grid:
    """Return all that was measured on a route: a row for each autonomy and round trip."""
    rows = [_row(cell) for cell in study.cells if cell.route == route.name]
    title = f"{route.name}: {route.what}, {route.length_m:.1f} m"
    return Grid(title, _COLUMNS, tuple(rows))


def sweep_grid(study: DelayStudy) -> Grid | None:
    """Return the finer sweep of `joint`: a row for each round trip; None where there is none."""
    if not study.joint_sweep:
        return None
    names = [route.name for route in study.routes]
    columns = [Column("RTT [s]")]
    for name in names:
        columns += [Column(f"{name}: success"), Column("95 % CI [%]", spare=1), Column("falls"), Column("time [s]")]
    rows = []
    for rtt_s in sorted({cell.rtt_s for cell in study.joint_sweep}):
        row = [f"{rtt_s:g}"]
        for name in names:
            cell = next(one for one in study.joint_sweep if (one.route, one.rtt_s) == (name, rtt_s))
            row += [f"{cell.successes}/{cell.flights}", interval(cell.wilson95), str(cell.falls), _text(cell.time_s)]
        rows.append(tuple(row))
    return Grid(f"{JOINT.name}, by round trip", tuple(columns), tuple(rows))


def claims_grid(study: DelayStudy) -> Grid:
    """Return the tested claims; of a few flights, that they are too few to test one."""
    seeds = len(study.seeds)
    few = f"too few flights: {seeds} a cell"
    columns = (
        Column("claim", is_text=True),
        Column("route", is_text=True),
        Column("result", is_text=True),
        Column("found", is_text=True),
    )
    rows = [
        (one.claim, one.route, few if seeds < FEWEST and one.finding != UNMEASURED else one.finding, one.found)
        for one in study.claims
    ]
    return Grid("Claims tested", columns, tuple(rows))


def tables(study: DelayStudy) -> list[Grid]:
    """Return all tables: times at a glance, claims, each route, the finer sweep."""
    glances = [overview(study, route) for route in study.routes]
    grids = [*glances, claims_grid(study), *(route_grid(study, route) for route in study.routes)]
    sweep = sweep_grid(study)
    return grids if sweep is None else [*grids, sweep]


def to_csv(study: DelayStudy) -> str:
    """Return the cells, those of the finer sweep too, with all digits: a row each, and nothing where nothing is."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    estimates = ("time_s", "distance_m", "standing_s", "standing_share")
    plain = ("route", "autonomy", "rtt_s", "flights", "successes", "rate", "falls", "exchanges")
    writer.writerow(
        [*plain, "wilson95_low", "wilson95_high", *(f"{name}{end}" for name in estimates for end in ("", "_half95"))]
    )
    for cell in dict.fromkeys((*study.cells, *study.joint_sweep)):
        row = [getattr(cell, name) for name in plain] + list(cell.wilson95)
        for name in estimates:
            estimate: Estimate | None = getattr(cell, name)
            row += ["", ""] if estimate is None else [estimate.value, "" if estimate.half is None else estimate.half]
        writer.writerow("" if value is None else value for value in row)
    return file.getvalue()


def _flown_by(study: DelayStudy, route: Route) -> str:
    seeds = f"{len(study.seeds)} seeds" if len(study.seeds) > 1 else f"seed {study.seeds[0]}"
    think = f", think time {route.think_s:g} s" if route.think_s else ""
    return f"{study.policy}, {seeds}{think}"


def _time(cell: Cell) -> str:
    if cell.time_s is None:
        return "none"
    return f"{cell.time_s.value:.1f}{'' if cell.successes == cell.flights else ' *'}"


def _row(cell: Cell) -> tuple[str, ...]:
    return (
        cell.autonomy,
        f"{cell.rtt_s:g}",
        f"{cell.successes}/{cell.flights}",
        interval(cell.wilson95),
        _text(cell.time_s),
        _text(cell.distance_m),
        _text(cell.standing_s),
        "" if cell.standing_share is None else f"{cell.standing_share.value:.0%}",
        str(cell.falls),
        "" if cell.exchanges is None else f"{cell.exchanges:g}",
    )


def _text(estimate: Estimate | None) -> str:
    return "" if estimate is None else str(estimate)
