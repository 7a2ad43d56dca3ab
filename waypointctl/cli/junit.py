"""JUnit XML of flights: a suite with a case a mission, as CI servers read it (Jenkins' junit-10.xsd).

Times in it are simulated seconds, as its property `clock` states; it holds no wall-clock time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal
from xml.etree import ElementTree

from waypointctl.display_text import printable, printable_lines

SUITE: Final = "waypointctl run"


@dataclass(frozen=True, slots=True)
class Case:
    """What came of a mission file.

    Attributes:
        name: the file.
        verdict: "failure": flown, and the answer is no; "error": could not be flown; "skipped": was not.
        text: the reason and details.
        time_s: simulated.
        output: for people.
    """

    name: str
    verdict: Literal["success", "failure", "error", "skipped"]
    text: str
    time_s: float
    output: str = ""


def junit_xml(cases: Sequence[Case]) -> bytes:
    """Return the report of some missions."""
    counts = {
        "tests": len(cases),
        "failures": sum(case.verdict == "failure" for case in cases),
        "errors": sum(case.verdict == "error" for case in cases),
    }
    numbers = {name: str(count) for name, count in counts.items()}
    time = _time(sum(case.time_s for case in cases))
    root = ElementTree.Element("testsuites", {"name": SUITE, **numbers, "time": time})
    skipped = str(sum(case.verdict == "skipped" for case in cases))
    suite = ElementTree.SubElement(root, "testsuite", {"name": SUITE, **numbers, "skipped": skipped, "time": time})
    properties = ElementTree.SubElement(suite, "properties")
    ElementTree.SubElement(properties, "property", {"name": "clock", "value": "simulation"})
    for case in cases:
        _add(suite, case)
    ElementTree.indent(root)
    report: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return report + b"\n"


def _add(suite: ElementTree.Element, case: Case) -> None:
    attributes = {"classname": SUITE, "name": printable(case.name), "time": _time(case.time_s)}
    element = ElementTree.SubElement(suite, "testcase", attributes)
    if case.verdict == "skipped":
        ElementTree.SubElement(element, "skipped", {"message": printable(case.text.partition("\n")[0])})
    elif case.verdict != "success":
        attributes = {"type": case.verdict, "message": printable(case.text.partition("\n")[0])}
        ElementTree.SubElement(element, case.verdict, attributes).text = printable_lines(case.text)
    if case.output:
        ElementTree.SubElement(element, "system-out").text = printable_lines(case.output)


def _time(seconds: float) -> str:
    return f"{seconds:.3f}"
