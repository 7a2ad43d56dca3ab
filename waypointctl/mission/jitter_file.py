"""Measured jitter: a text file with one number of seconds a line, '#' before what is for people."""

from __future__ import annotations

from typing import Final

from waypointctl.mission.problems import Problem
from waypointctl.mission.text_problems import TextReport, Word

MOST_S: Final = 86_400.0


def read_jitter(source: bytes, where: str) -> tuple[tuple[float, ...], tuple[Problem, ...]]:
    """Return the numbers [s] that a file holds, and everything that is wrong with it.

    Args:
        source: the file's bytes.
        where: its name, for the problems.
    """
    report = TextReport(where)
    samples = []
    for word, *others in report.lines(source):
        value = _seconds(word, report)
        if others:
            report.add(others[0], f"'{others[0].text}' follows the number; one number of seconds stands on a line")
        if value is not None:
            samples.append(value)
    if not samples and not report.problems:
        report.add(None, "holds no number; a file of jitter has one number of seconds a line")
    return tuple(samples), tuple(report.problems)


def _seconds(word: Word, report: TextReport) -> float | None:
    try:
        value = float(word.text)
    except ValueError:
        report.add(word, f"'{word.text}' is not a number of seconds")
        return None
    if not abs(value) <= MOST_S:
        report.add(word, f"{word.text} is not between -{MOST_S:g} and {MOST_S:g} s")
        return None
    return value
