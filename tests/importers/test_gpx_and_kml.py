from __future__ import annotations

from pathlib import Path

import pytest

from tests.importers.reading import imported
from waypointctl.errors import MissionError

PLACES = ((60.0, 25.0), (60.0002, 25.0), (60.0002, 25.0004))
ON_THE_WAY = [(0.0, 22.28), (22.32, 22.28)]


def points(tag: str, *places: tuple[float, float], inside: str = "<ele>3</ele>") -> str:
    return "".join(f'<{tag} lat="{latitude}" lon="{longitude}">{inside}</{tag}>' for latitude, longitude in places)


def gpx(*parts: str) -> str:
    head = '<?xml version="1.0"?><gpx version="1.1" creator="x" xmlns="http://www.topografix.com/GPX/1/1">'
    return f"{head}<metadata><name>m</name></metadata>{''.join(parts)}</gpx>"


ROUTE = f"<rte><name>the yard</name>{points('rtept', *PLACES)}</rte>"
TRACK = f"<trk><trkseg>{points('trkpt', *PLACES, inside='<time>2026-01-01T00:00:00Z</time>')}</trkseg></trk>"


def coordinates(*places: tuple[float, float]) -> str:
    return f"<coordinates>\n{' '.join(f'{longitude},{latitude},0' for latitude, longitude in places)}\n</coordinates>"


def kml(*parts: str, prefix: str = "") -> str:
    text = f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Folder>{"".join(parts)}</Folder></Document></kml>'
    return text.replace("<", f"<{prefix}").replace(f"<{prefix}/", f"</{prefix}") if prefix else text


def placemark(geometry: str, name: str = "") -> str:
    return f"<Placemark><name>{name}</name><styleUrl>#s</styleUrl>{geometry}</Placemark>"


LINE = placemark(f"<LineString><tessellate>1</tessellate>{coordinates(*PLACES)}</LineString>", "the yard")


def track(*places: tuple[float, float]) -> str:
    inside = (f"<when>x</when><gx:coord>{east} {north} 0</gx:coord>" for north, east in places)
    return f"<gx:Track>{''.join(inside)}</gx:Track>"


GX_TRACK = placemark(track(*PLACES))
POLYGON = placemark(
    f"<Polygon><outerBoundaryIs><LinearRing>{coordinates(*PLACES)}</LinearRing></outerBoundaryIs></Polygon>"
)


@pytest.mark.parametrize(
    ("content", "name", "left_out"),
    [
        (gpx(ROUTE), "the-yard", ()),
        (gpx(TRACK), "yard", ()),
        (gpx(f"<trk><trkseg/>{TRACK[5:-6]}<trkseg></trkseg></trk>"), "yard", ()),
        (gpx(points("wpt", *PLACES), TRACK), "yard", ("3 waypoints",)),
        (gpx("<rte></rte>", TRACK), "yard", ("1 x rte without points",)),
        (
            gpx(
                TRACK.replace(
                    '<trkpt lat="60.0002" lon="25.0004">', '</trkseg><trkseg><trkpt lat="60.0002" lon="25.0004">'
                )
            ),
            "yard",
            ("1 x gap between segments of a track: the robot goes straight across",),
        ),
        (
            gpx(ROUTE.replace("<ele>3</ele>", "<extensions><x:E xmlns:x='x'><x:rpt/><x:rpt/></x:E></extensions>", 1)),
            "the-yard",
            ("2 x shaping point (rpt) of a route: the robot goes straight between route points",),
        ),
        (gpx(ROUTE).replace("<?xml version", "\ufeff<?xml version"), "the-yard", ()),
        (gpx(ROUTE).replace('version="1.0"?>', 'version="1.0" encoding="latin-1"?>'), "the-yard", ()),
        (kml(LINE), "the-yard", ()),
        (kml(LINE, prefix="kml:"), "the-yard", ()),
        (kml(GX_TRACK), "yard", ()),
        (kml(LINE.replace(",", ",\n ")), "the-yard", ()),
        (kml(LINE.replace(",", " , ")), "the-yard", ()),
        (
            kml(placemark(f"<gx:MultiTrack>{track(*PLACES[:1])}{track()}{track(*PLACES[1:])}</gx:MultiTrack>")),
            "yard",
            ("1 x gap between segments of a track: the robot goes straight across",),
        ),
        (kml(placemark(f"<MultiGeometry><LineString>{coordinates(*PLACES)}</LineString></MultiGeometry>")), "yard", ()),
        (
            kml(
                LINE,
                placemark(f"<Point>{coordinates(PLACES[0])}</Point>"),
                POLYGON,
                "<NetworkLink><Link/></NetworkLink>",
            ),
            "the-yard",
            ("1 Point", "1 Polygon", "1 x NetworkLink"),
        ),
    ],
)
def test_the_one_line_is_the_path_and_all_else_is_counted(
    tmp_path: Path, content: object, name: str, left_out: tuple[str, ...]
) -> None:
    file = "yard.kml" if "<kml" in str(content) or "kml:" in str(content) else "yard.gpx"
    found = imported(tmp_path, content.encode() if isinstance(content, str) else content, file)
    assert (found.mission.name, found.mission.start.position_m) == (name, (0, 0))
    assert found.legs == ON_THE_WAY
    assert found.left_out == left_out


@pytest.mark.parametrize(
    ("content", "file"),
    [
        (gpx(*(points("wpt", place, inside=f"<name>stop {at}</name>") for at, place in enumerate(PLACES))), "yard.gpx"),
        (
            kml(*(placemark(f"<Point>{coordinates(place)}</Point>", f"stop {at}") for at, place in enumerate(PLACES))),
            "yard.kml",
        ),
    ],
)
def test_without_a_line_the_points_are_the_path_in_their_order(tmp_path: Path, content: str, file: str) -> None:
    found = imported(tmp_path, content, file)
    assert found.legs == ON_THE_WAY
    assert [leg.name for leg in found.all_legs] == ["stop 1", "stop 2"]


BOMB = '<!DOCTYPE gpx [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
FETCH = '<!DOCTYPE gpx [<!ENTITY a SYSTEM "file:///etc/passwd">]>'


@pytest.mark.parametrize(
    ("content", "file", "problem"),
    [
        (gpx(), "m.gpx", "has no route or track; a mission is one route or track, or 2 waypoints and more"),
        (
            gpx(ROUTE, TRACK),
            "m.gpx",
            r"has 2 lines \('the yard', line 1 \(trk\)\); a mission is one route or track: keep",
        ),
        (
            gpx(f"<rte>{points('rtept', *PLACES * 6_667)}</rte>"),
            "m.gpx",
            r"line 1 \(rte\): has 20,001 points; at most 20,000",
        ),
        (gpx(ROUTE).replace('lat="60.0"', ""), "m.gpx", r"line 1 \(rtept\): the latitude is missing$"),
        (gpx(ROUTE).replace('lat="60.0"', 'lat="91"'), "m.gpx", r"line 1 \(rtept\): 91, 25 is not a latitude"),
        (gpx(ROUTE)[:-6], "m.gpx", r"m\.gpx:1:\d+: is not XML: no element found"),
        (gpx(ROUTE).replace("60.0", "&a;"), "m.gpx", r"m\.gpx:1:\d+: is not XML: undefined entity"),
        (BOMB + gpx(ROUTE)[21:], "m.gpx", r"m\.gpx:1: has a document type declaration"),
        (FETCH + gpx(ROUTE)[21:], "m.gpx", r"m\.gpx:1: has a document type declaration"),
        ('<?xml version="1.0" encoding="klingon"?><gpx/>', "m.gpx", "is not XML that can be read: unknown encoding"),
        (gpx("<a>" * 101, "</a>" * 101), "m.gpx", "has elements more than 100 deep"),
        (
            kml(LINE).replace("<kml", '<kml hint="target=sky"'),
            "m.kml",
            r"line 1 \(kml\): its hint names 'sky', which is",
        ),
        (kml(), "m.kml", "has no LineString; a mission is one LineString, or 2 Points and more"),
        (kml(POLYGON), "m.kml", "has no LineString and 1 Polygon; a mission is one"),
        (kml(LINE, GX_TRACK), "m.kml", r"has 2 lines \('the yard', line 3 \(Track\)\)"),
        (kml(LINE.replace(",60.0,", ",")), "m.kml", r"position 1: 0, 25 is not|some 6,700 km away"),
        (
            kml(LINE.replace("25.0,60.0,0", "25.0")),
            "m.kml",
            r"LineString\), position 1: '25\.0' is not longitude,latitude",
        ),
        (
            kml(LINE.replace("25.0,", "abc,")),
            "m.kml",
            r"'abc' is not a finite number of degrees \(and 1 more of the kind",
        ),
        (
            kml(placemark(f"<LineString>{coordinates(*PLACES * 6_667)}</LineString>")),
            "m.kml",
            "has 20,001 positions; at most 20,000",
        ),
        ("<osm/>", "m.gpx", "is XML, and neither GPX nor KML"),
    ],
)
def test_what_is_no_path_is_refused_one_problem_a_cause(tmp_path: Path, content: str, file: str, problem: str) -> None:
    with pytest.raises(MissionError, match=problem) as caught:
        imported(tmp_path, content, file)
    assert str(caught.value).count(file) == 1


@pytest.mark.parametrize(
    ("hint", "metres"), [("target=moon", 6.065), ("a=b target=Mars", 11.855), ("target=earth", 22.28)]
)
def test_a_kml_files_hint_names_its_body(tmp_path: Path, hint: str, metres: float) -> None:
    found = imported(tmp_path, kml(LINE).replace("<kml", f'<kml hint="{hint}"'), "yard.kml")
    assert found.legs[0] == pytest.approx((0, metres), abs=0.01)


def test_elements_have_a_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("waypointctl.importers.gpx_and_kml._MOST_ELEMENTS", 20)
    assert imported(tmp_path, gpx(ROUTE), "m.gpx").legs == ON_THE_WAY
    with pytest.raises(MissionError, match="has more than 20 elements"):
        imported(tmp_path, gpx(ROUTE, "<a/>" * 20), "m.gpx")
