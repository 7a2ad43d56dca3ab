from __future__ import annotations

from pathlib import Path

import pytest

from tests.importers.reading import imported
from waypointctl.errors import MissionError

ROWS = ((60.0, 25.0), (60.0002, 25.0), (60.0002, 25.0004))
ON_THE_WAY = [(0.0, 22.28), (22.32, 22.28)]


def table(header: str, row: str = "{0},{1}", rows: tuple[tuple[float, float], ...] = ROWS) -> str:
    return "\n".join((header, *(row.format(*each) for each in rows), ""))


@pytest.mark.parametrize(
    ("content", "left_out"),
    [
        (table("lat,lon"), ()),
        (table("Latitude, Longitude"), ()),
        ("# from a logger\n\n# twice\n" + table("lat,lon"), ()),
        (table("lon,lat,alt", "{1},{0},30"), ("column 'alt'",)),
        (table('"LAT (deg)";"LNG [deg]";"id"', "{0};{1};7"), ("column 'id'",)),
        (table("lat [°],lon(°)"), ()),
        (table("lat,lon", '"{0}","{1}"').replace(".", ","), ()),
        ("sep=;\n" + table("lat;lon", "{0};{1}"), ()),
        (table("latitude_deg\tlongitude_deg", "{0}\t{1}"), ()),
        (table("lat;lon", "{0};{1}").replace(".", ","), ()),
        ("\ufeff" + table("lat,lon").replace("\n", "\r\n\r\n"), ()),
        (table("lat,lon,x,y", "{0},{1},1,2"), ("column 'x'", "column 'y'")),
    ],
)
def test_rows_are_walked_from_the_first(tmp_path: Path, content: str, left_out: tuple[str, ...]) -> None:
    found = imported(tmp_path, content, "yard.csv")
    assert (found.mission.name, found.mission.start.position_m) == ("yard", (0, 0))
    assert found.legs == ON_THE_WAY
    assert found.left_out == left_out


def test_metres_stay_what_they_are(tmp_path: Path) -> None:
    found = imported(tmp_path, "name,x_m,y_m,hold_s,tolerance\n,1,2,,\npit,3.5,-4,10,1.5\n,0,0,,\n", "yard.csv")
    assert found.mission.start.position_m == (1, 2)
    assert found.legs == [(3.5, -4.0), (0.0, 0.0)]
    first, second = found.all_legs
    assert (first.name, first.hold_s, first.acceptance, first.tolerance_m) == ("pit", 10, "radius", 1.5)
    assert (second.name, second.hold_s, second.acceptance, second.tolerance_m) == ("WP2", 0, "box", 0.5)
    assert found.text.startswith("# From 'yard.csv'. x and y are those of the file, in metres.\n")
    assert found.source.remarks == ()


def test_x_and_y_without_a_unit_are_said_to_be_metres(tmp_path: Path) -> None:
    assert imported(tmp_path, "Easting (m),Northing (m)\n25,60\n26,61\n", "yard.csv").legs == [(26.0, 61.0)]
    found = imported(tmp_path, "X,Y\n25,60\n25.1,60\n", "yard.csv")
    assert (found.mission.start.position_m, found.legs) == ((25, 60), [(25.1, 60.0)])
    assert found.source.remarks == ("has x and y without a unit: they are read as metres",)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (
            table("north_deg,east_deg").replace("north", "n"),
            "yard.csv:1: has the columns 'n_deg', 'east_deg'; 'lat' and",
        ),
        ("60,25\n60.1,25\n", "yard.csv:1: has the columns '60', '25'; 'lat' and 'lon'"),
        ("# nothing\n", "yard.csv:1: has no columns; 'lat' and 'lon'"),
        ('""\n""', "yard.csv:1: has no columns; 'lat' and 'lon'"),
        ("lat,lon\n", "has 0 rows; 2 to 1,001 are allowed: the start and the waypoints"),
        ("lat,lon\n60,25\n", "has 1 row; 2 to 1,001 are allowed"),
        (table("lat,lon", rows=ROWS * 334), "has more than 1,001 rows; 2 to 1,001 are allowed"),
        ("lat,lon\n60,25\n60\n", "line 3: has 1 value; the first line names 2 columns"),
        ("lat,lon\n60,25\n60,x\n", "line 3: 'x' is not a finite number of degrees"),
        ("lat,lon\n60,25\nnan,25\n", "line 3: 'nan' is not a finite number of degrees"),
        ("lat,lon\n60,25\n60,1_0\n", "line 3: '1_0' is not a finite number of degrees"),
        ("lat,lon\n60,25\n60,\n", "line 3: the longitude is missing"),
        ("lat,lon\n151.2,-33.8\n151.2,-33.9\n", r"line 2: 151\.2, -33\.8 is not .*; they look swapped \(and 1 more"),
        ('x,y\n"1,2",0\n1,2\n', "line 2: '1,2' is not a number of metres"),
        ("lat,lon\n60,25\n91,25\n", "line 3: 91, 25 is not a latitude within"),
        ("x,y\n0,0\n1,two\n", "line 3: 'two' is not a number of metres"),
        ("x,y\n385000,6671000\n385001,6671000\n", r"line 2: \(385000, 6671000\) is not within 10000 m .* \(and 1 more"),
        ("x,y,hold\n0,0,\n1,1,-3\n", "line 3: hold '-3' is not a number within 0 and 86400"),
        ("x,y,tolerance\n0,0,\n1,1,1e9\n", "line 3: tolerance '1e9' is not a number within 0 and 100"),
        ('lat,lon\n60,"25' + "5" * 200_000, "yard.csv:2: is not CSV: field larger than field limit"),
    ],
)
def test_what_is_wrong_is_told_with_its_line(tmp_path: Path, content: str, problem: str) -> None:
    with pytest.raises(MissionError, match=problem) as caught:
        imported(tmp_path, content, "yard.csv")
    assert str(caught.value).count("yard.csv") == 1
