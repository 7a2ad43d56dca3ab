from __future__ import annotations

import csv
import io

from tests.studies.standing import cells, line
from waypointctl.evaluation.grid import markdown_file
from waypointctl.studies.claims import assess_claims, joint_limits
from waypointctl.studies.delay import DelayStudy, Route
from waypointctl.studies.tables import MARKDOWN_HEAD, claims_grid, overview, route_grid, sweep_grid, tables, to_csv

FLOWN = line("mission", {0.0: [10.0, 11.0], 2.56: [13.0, 13.0]}) + line(
    "joint", {0.0: [10.0, None], 2.56: [None, None]}
)
SWEEP = line("joint", {0.0: [10.0, None], 0.02: [10.5, 10.5]})


def study(*, swept: bool = True) -> DelayStudy:
    found, sweep = cells(FLOWN), cells(SWEEP) if swept else ()
    return DelayStudy(
        policy="walker",
        policy_sha256="0" * 64,
        source="abc",
        think_s=1.5,
        seeds=(0, 1),
        routes=(Route(name="r", waypoints=2, length_m=21.2, think_s=1.5),),
        cells=found,
        joint_sweep=sweep,
        joint_limits=joint_limits((*found, *sweep)),
        claims=assess_claims(found, FLOWN),
    )


def test_the_times_at_a_glance() -> None:
    grid = overview(study(), study().routes[0])
    assert grid.title == "r: time until the operator knows, walker, 2 seeds, think time 1.5 s"
    assert [column.heading for column in grid.columns] == ["autonomy", "0 s", "2.56 s"]
    assert grid.rows == (("mission", "10.5", "13.0"), ("joint", "10.0 *", "none"))


def test_a_routes_table_has_all_that_was_measured() -> None:
    grid = route_grid(study(), study().routes[0])
    assert grid.title == "r: 2 waypoints, 21.2 m"
    assert len(grid.rows) == 4
    # t of one degree of freedom is 12.706, the error of 10 and 11 is 0.5.
    assert grid.rows[0] == (
        "mission", "0", "2/2", "34.2-100.0", "10.50 ± 6.35", "20.00 ± 0.00", "2.62 ± 1.59", "25%", "0", "1",
    )  # fmt: skip
    assert grid.rows[3] == ("joint", "2.56", "0/2", "0.0-65.8", "", "", "", "", "2", "")


def test_of_a_few_flights_no_claim_is_tested() -> None:
    few, enough = study(), study().model_copy(update={"seeds": (0, 1, 2, 3, 4)})
    findings = [one.finding for one in few.claims]
    assert findings == ["holds", "not measured"]
    assert [row[2] for row in claims_grid(few).rows] == ["too few flights: 2 a cell", "not measured"]
    assert [row[2] for row in claims_grid(enough).rows] == findings
    assert claims_grid(few).rows[0][3] == few.claims[0].found


def test_the_finer_sweep_is_a_table_of_its_own() -> None:
    grid = sweep_grid(study())
    assert grid is not None
    assert [row[:2] for row in grid.rows] == [("0", "1/2"), ("0.02", "2/2")]
    assert len(tables(study())) == 4
    assert sweep_grid(study(swept=False)) is None
    assert len(tables(study(swept=False))) == 3


def test_a_line_of_the_picture_goes_through_the_finer_sweep() -> None:
    assert [cell.rtt_s for cell in study().cells_of("r", "joint")] == [0.0, 0.02, 2.56]


def test_ferrells_prediction_is_the_walk_and_a_round_trip_with_a_thought_for_each_command() -> None:
    assert study().undelayed_s("r") == 10.5
    assert study().predicted_s("r", "mission", 40.0) == 10.5 + 1 * (40.0 + 1.5)
    assert study().predicted_s("r", "waypoint", 40.0) is None


def test_the_values_have_all_digits_and_each_cell_once() -> None:
    rows = list(csv.DictReader(io.StringIO(to_csv(study()))))
    assert [(row["autonomy"], float(row["rtt_s"])) for row in rows] == [
        ("mission", 0.0), ("mission", 2.56), ("joint", 0.0), ("joint", 2.56), ("joint", 0.02),
    ]  # fmt: skip
    first, _, one, none, _ = rows
    assert float(first["time_s"]) == 10.5
    assert float(first["time_s_half95"]) == study().cells[0].time_s.half  # type: ignore[union-attr]
    assert (one["time_s"], one["time_s_half95"], none["time_s"]) == ("10.0", "", "")


def test_the_markdown_is_every_table() -> None:
    text = markdown_file(MARKDOWN_HEAD, tables(study()))
    assert text.startswith("<!-- waypointctl study delay -->\n")
    assert text.count("\n**") == 4
    assert r"| joint | 10.0 \* | none |" in text


def test_a_study_is_read_back_as_it_was() -> None:
    assert DelayStudy.model_validate_json(study().model_dump_json()) == study()
