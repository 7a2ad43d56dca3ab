"""Contact plans as ION's ionadmin reads them (ionrc(5)): when two nodes can talk, how fast, and how far apart they are.

    a contact +0 +3600 1 2 100000     from, to [s], source node, destination node, [bytes/s]
    a range   +0 +3600 1 2 1          from, to [s], one node, the other node, one-way light time [s]

'+' counts from mission start, or from what an '@' line sets. A range from a lower node number to a higher one holds
both ways, unless the opposite direction has ranges of its own. What says nothing of when the two nodes of a link can
talk is passed over: lines about other nodes, commands that list or set something else, registrations, hypothetical
contacts (a time of 0), contacts and ranges that are over by mission start, and what '## begin' and '## end' mark as
another program's. Those that would change the plan for the two nodes are refused.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field, replace
from datetime import datetime
from itertools import pairwise
from typing import Final

from waypointctl.mission.file_kind import FileKind, kind_of
from waypointctl.mission.problems import Problem
from waypointctl.mission.text_file import ABSOLUTE, TextReport, Word, moment_of

MOST: Final = 1e9  # [s] or [bytes/s]; thirty years, or a rate that no radio has
BITS_PER_BYTE: Final = 8

_OTHER_PROGRAM: Final = re.compile(rb"^##\s*begin\s+(?!ionadmin\b)\S+.*?^##\s*end\b", re.MULTILINE | re.DOTALL)
_CONTACT: Final = ("start time", "stop time", "source node", "destination node", "rate in bytes/s")
_RANGE: Final = ("start time", "stop time", "one node", "other node", "light time in s")
_MOST_SHOWN: Final = 8  # of the ways that a plan has contacts of
_MAX_DIGITS: Final = 18  # of a node number


@dataclass(frozen=True, slots=True)
class Span:
    """From when to when [s] after mission start a contact or a range holds in one direction, and its value.

    One that began earlier holds from mission start.
    """

    begin_s: float
    end_s: float
    value: float  # of a contact its rate [bit/s], of a range the one-way light time [s]
    at: Word = field(compare=False)  # position in the file


@dataclass(frozen=True, slots=True)
class Passage:
    """One direction of a contact plan."""

    contacts: tuple[Span, ...]  # in order, none overlapping another
    ranges: tuple[Span, ...]  # the same; where the plan's light times are used they cover the contacts


def read_contact_plan(
    source: bytes, where: str, way: tuple[int, int], *, reference: str | None = None, needs_ranges: bool = True
) -> tuple[Passage, tuple[Problem, ...]]:
    """Return one direction of a contact plan, and every problem in the plan.

    Args:
        source: the plan's bytes.
        where: its name, for the problems.
        way: from which node to which.
        reference: the moment of mission start, as yyyy/mm/dd-hh:mm:ss; without it absolute times are refused.
        needs_ranges: whether each contact has to be within a range.
    """
    if kind := kind_of(source):
        is_json = kind in (FileKind.JSON, FileKind.HDTN_PLAN)
        wanted = ", not" if is_json else "; expected is"
        text = f"{kind.value}{wanted} a contact plan in ION's terms ('a contact ...')"
        return Passage((), ()), (Problem(where, 0, 0, "", text),)
    plan = _Plan(TextReport(where), way, moment_of(reference) if reference else None)
    own = _OTHER_PROGRAM.sub(lambda found: b"\n" * found.group().count(b"\n"), source)
    for words in plan.report.lines(own):
        plan.take(words)
    contacts = plan.ordered(plan.contacts, "contact")
    other_way = plan.ranges.get(way[::-1], []) if way[0] > way[1] else []  # of a lower node first: it holds both ways
    ranges = plan.ordered(plan.ranges.get(way, other_way), "range")
    if not plan.report.problems:
        plan.check(contacts, ranges if needs_ranges else None)
    return Passage(contacts, ranges), tuple(plan.report.problems)


class _Plan:
    """Collects the lines of one direction."""

    def __init__(self, report: TextReport, way: tuple[int, int], reference: datetime | None) -> None:
        self.report = report
        self.contacts: list[Span] = []
        self.ranges: dict[tuple[int, int], list[Span]] = {}  # of the way and of the way back
        self._way = way
        self._others: set[tuple[int, int]] = set()  # ways that the plan has contacts of beside this one
        self._hypothetical: Word | None = None
        self._reference = reference
        self._offset_s = 0.0  # of '+0', after mission start
        self._over: Word | None = None  # a contact that ended before mission start
        self._absolute: Word | None = None  # the first absolute time, of whatever nodes: one cause has one place
        self._is_dateless = False  # an absolute time without a reference was found: one cause, one problem

    def take(self, words: list[Word]) -> None:
        """Read a line."""
        command, *rest = words
        self._absolute = self._absolute or next((word for word in rest if ABSOLUTE.fullmatch(word.text)), None)
        if command.text == "@":
            if len(rest) == 1:
                self._offset_s = self._time(rest[0])
            else:
                self.report.add(command, "'@' needs a time")
            return
        kind = rest[0].text if rest else ""
        if kind not in ("contact", "range") or command.text not in ("a", "c", "d"):
            return
        nodes = rest[3:5] if command.text == "a" else rest[2:4]
        if self._is_of_others(kind, [_node_number(word) for word in nodes]):
            return
        if command.text != "a":
            problem = f"'{command.text} {kind}' would change the plan; write the plan as it is to be, with 'a {kind}'"
            self.report.add(command, problem)
        elif kind == "contact":
            self._add_contact(command, rest[1:])
        else:
            self._add_range(command, rest[1:])

    def _is_of_others(self, kind: str, nodes: list[int | None]) -> bool:
        """Tell whether a line is about other nodes than the way's; one whose nodes cannot be read is not."""
        if kind == "range":
            return any(node is not None and node not in self._way for node in nodes)
        is_other = any(node not in (None, end) for node, end in zip(nodes, self._way, strict=False))
        if is_other and len(nodes) == 2 and nodes[0] is not None and nodes[1] is not None and nodes[0] != nodes[1]:
            self._others.add((nodes[0], nodes[1]))
        return is_other

    def ordered(self, spans: list[Span], kind: str) -> tuple[Span, ...]:
        """Return spans in the order of time, and report those that overlap."""
        spans = sorted(spans, key=lambda span: span.begin_s)
        for before, after in pairwise(spans):
            if after.begin_s < before.end_s:
                self.report.add(after.at, f"this {kind} overlaps that of line {before.at.line}")
        return tuple(spans)

    def check(self, contacts: tuple[Span, ...], ranges: tuple[Span, ...] | None) -> None:
        """Report that there is no contact, or one without a range."""
        nodes = f"from node {self._way[0]} to node {self._way[1]}"
        if not contacts and self._over is not None:
            self.report.add(self._over, f"this contact is over by mission start, as are all {nodes}")
        elif not contacts and self._hypothetical is not None:
            problem = "this contact is hypothetical (a time is 0): it has no time; mission start is +0"
            self.report.add(self._hypothetical, problem)
        elif not contacts:
            known = ", ".join(f"from {a} to {b}" for a, b in sorted(self._others)[:_MOST_SHOWN]) or "none at all"
            known += f" and {len(self._others) - _MOST_SHOWN} more" if len(self._others) > _MOST_SHOWN else ""
            self.report.add(None, f"has no contact {nodes}; its contacts are {known}")
        for contact in contacts if ranges is not None else ():
            if (gap_s := _gap(contact, ranges or ())) is not None:
                problem = f"there is no range {nodes} at +{gap_s:g} s of this contact"
                self.report.add(contact.at, f"{problem}; add one, or give the link a delay in the mission")

    def _add_contact(self, command: Word, words: list[Word]) -> None:
        if words and words[0].text == "-1":
            return  # registers a node, without a contact
        if "0" in (word.text for word in words[:2]):
            self._hypothetical = command
            return
        confidence = words[len(_CONTACT) :][:1]
        span = self._span(command, words[: len(_CONTACT)] + words[len(_CONTACT) + 1 :], _CONTACT, least=1)
        if confidence and self._number(confidence[0], "confidence", least=0) != 1:
            self.report.add(confidence[0], "only a contact that is certain can be flown: leave the confidence out")
        elif span is not None and span[1].end_s <= 0:
            self._over = self._over or command
        elif span is not None:
            self.contacts.append(replace(span[1], value=BITS_PER_BYTE * span[1].value))

    def _add_range(self, command: Word, words: list[Word]) -> None:
        span = self._span(command, words, _RANGE, least=0)
        if span is not None and not span[1].end_s <= 0:
            self.ranges.setdefault(span[0], []).append(span[1])

    def _span(
        self, command: Word, words: list[Word], wanted: tuple[str, ...], least: float
    ) -> tuple[tuple[int, int], Span] | None:
        """Return the values of a line, or None after reporting its problems."""
        before = len(self.report.problems)
        if len(words) != len(wanted):
            self.report.add(command, f"has {len(words)} values; expected are {', '.join(wanted)}")
            return None
        begin_s, end_s = self._time(words[0]), self._time(words[1])
        way = self._node(words[2]), self._node(words[3])
        value = self._number(words[4], wanted[4], least)
        if len(self.report.problems) == before and end_s <= begin_s:
            self.report.add(words[1], f"{words[1].text} is not after {words[0].text}")
        return (way, Span(max(begin_s, 0.0), end_s, value, command)) if len(self.report.problems) == before else None

    def _time(self, word: Word) -> float:
        """Return a time in [s] after mission start."""
        if word.text.startswith("+"):
            return self._offset_s + self._number(word, "time", least=0)
        moment = moment_of(word.text)
        if moment is None:
            problem = f"'{word.text}' is not a time: write +seconds"
        elif self._reference is None:
            if self._is_dateless:
                return math.nan  # compares with nothing: no further problem is reported
            self._is_dateless = True
            word = self._absolute or word
            problem = (
                f"{word.text} is an absolute time, and the mission has no date; write +seconds after mission start, "
                "or give the contact_plan in the mission the date of its start as 'reference'"
            )
        else:
            return (moment - self._reference).total_seconds()
        self.report.add(word, problem)
        return 0.0

    def _node(self, word: Word) -> int:
        number = _node_number(word)
        if number is None:
            self.report.add(word, f"'{word.text}' is not a node number")
        return number or 0

    def _number(self, word: Word, what: str, least: float) -> float:
        try:
            value = float(word.text)
        except ValueError:
            self.report.add(word, f"'{word.text}' is not a number: {what}")
            return least
        if least <= value <= MOST:
            return value
        self.report.add(word, f"{word.text} is not from {least:g} to {MOST:g}: {what}")
        return least


def _node_number(word: Word) -> int | None:
    is_number = word.text.isascii() and word.text.isdecimal() and len(word.text) <= _MAX_DIGITS
    return int(word.text) if is_number else None


def _gap(contact: Span, ranges: tuple[Span, ...]) -> float | None:
    """Return the first moment [s] of a contact that is in no range; None if there is none."""
    covered_s = contact.begin_s
    for each in ranges:
        if each.begin_s <= covered_s < each.end_s:
            covered_s = each.end_s
    return None if covered_s >= contact.end_s else covered_s
