from __future__ import annotations

import re
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

import pytest

from waypointctl.cli.run_many import Outcome, junit_xml
from waypointctl.flight.outcome import FlightResult
from waypointctl.units import ns


def flown(name: str, verdict: Literal["success", "failure"], reason: str, time_s: float) -> Outcome:
    result = FlightResult(verdict, reason, 1, 2, ns(time_s), ns(time_s), 7, 0)
    return Outcome(Path(name), verdict, reason, "mission", result)


CASES = [
    flown("a.yaml", "success", "2 of 2", 7.55),
    flown("b & <b>.yaml", "failure", "timeout: 1 of 2\nsecond line", 30.0),
    Outcome(Path("c.yaml"), "error", 'c.yaml:1:1: "x" \x07 \ud83d'),
    Outcome(Path("d.yaml"), "skipped", "not flown"),
]

# The parts of Jenkins' junit-10.xsd that a report of tests uses: required and allowed attributes, and children in
# order. Numbers are xs:string there; what reads them wants digits.
SCHEMA: dict[str, tuple[set[str], set[str], list[str]]] = {
    "testsuites": (set(), {"name", "time", "tests", "failures", "disabled", "errors"}, ["testsuite"]),
    "testsuite": (
        {"name", "tests"},
        {"failures", "errors", "group", "time", "skipped", "timestamp", "hostname", "id", "package", "file", "log"},
        ["properties", "testcase", "system-out", "system-err"],
    ),
    "testcase": (
        {"name"},
        {"assertions", "time", "classname", "status", "class", "file", "line"},
        ["skipped", "error", "failure", "system-out", "system-err"],
    ),
    "properties": (set(), set(), ["property"]),
    "property": ({"name", "value"}, set(), []),
    "failure": (set(), {"type", "message"}, []),
    "error": (set(), {"type", "message"}, []),
    "skipped": (set(), {"type", "message"}, []),
    "system-out": (set(), set(), []),
}


def check(element: ElementTree.Element) -> None:
    """Hold an element to the schema."""
    required, optional, children = SCHEMA[element.tag]
    assert required <= set(element.attrib) <= required | optional
    places = [children.index(child.tag) for child in element]
    assert places == sorted(places)
    for name in ("tests", "failures", "errors", "skipped"):
        assert re.fullmatch(r"\d+", element.get(name, "0"))
    assert re.fullmatch(r"\d+\.\d{3}", element.get("time", "0.000"))
    for child in element:
        check(child)


@pytest.mark.parametrize("count", range(5))
def test_a_report_is_what_the_schema_wants(count: int) -> None:
    root = ElementTree.fromstring(junit_xml(CASES[:count]))
    assert root.tag == "testsuites"
    assert len(root) == 1
    check(root)
    assert len(root.findall("./testsuite/testcase")) == count


def test_it_counts_and_tells_what_became_of_each() -> None:
    (suite,) = ElementTree.fromstring(junit_xml(CASES))
    counts = {"tests": "4", "failures": "1", "errors": "1", "skipped": "1", "time": "37.550"}
    assert counts.items() <= suite.attrib.items()
    success, failure, error, skipped = suite.findall("testcase")
    assert [child.tag for child in success] == ["system-out"]
    assert failure.get("name") == "b & <b>.yaml"
    assert failure[0].attrib == {"type": "failure", "message": "timeout: 1 of 2"}
    assert failure[0].text == "timeout: 1 of 2\nsecond line"
    assert error[0].text == r'c.yaml:1:1: "x" \u0007 \ud83d'
    assert [child.tag for child in skipped] == ["skipped"]
    assert skipped[0].attrib == {"message": "not flown"}
    assert sum(float(case.get("time", "")) for case in suite.findall("testcase")) == pytest.approx(37.55)


def test_it_says_whose_seconds_its_times_are() -> None:
    (suite,) = ElementTree.fromstring(junit_xml(CASES))
    assert suite[0].tag == "properties"
    assert [each.attrib for each in suite[0]] == [{"name": "clock", "value": "simulation"}]


def test_the_same_flights_give_the_same_bytes_without_a_clock() -> None:
    assert junit_xml(CASES) == junit_xml(list(CASES))
    assert b"timestamp" not in junit_xml(CASES)
