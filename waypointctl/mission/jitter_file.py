"""Measured jitter: a text file with one number of seconds a line, '#' before what is for people."""

from __future__ import annotations

from typing import Final

from waypointctl.mission.file_kind import kind_of
from waypointctl.mission.problems import Problem
from waypointctl.mission.text_problems import TextReport, Word

MOST_S: Final = 86_400.0


def read_jitter(
    source: bytes, where: str, least_delay_s: float | None = None
) -> tuple[tuple[float, ...], tuple[Problem, ...]]:
    """Return the numbers [s] that a file holds, and everything that is wrong with it.

    Args:
        source: the file's bytes.
        where: its name, for the problems.
        least_delay_s: the shortest delay of the link that it is for; nothing may arrive before it has left. None where
            that is not known, or was looked at before.
    """
    if kind := kind_of(source):
        return (), (Problem(where, 0, 0, "", f"{kind.value}; a file of jitter has one number of seconds a line"),)
    report = TextReport(where)
    samples = []
    for word, *others in report.lines(source):
        value = _seconds(word, report, least_delay_s)
        if others:
            report.add(others[0], f"'{others[0].text}' follows the number; one number of seconds stands on a line")
        if value is not None:
            samples.append(value)
    if not samples and not report.problems:
        report.add(None, "holds no number; a file of jitter has one number of seconds a line")
    return tuple(samples), tuple(report.problems)


def _seconds(word: Word, report: TextReport, least_delay_s: float | None) -> float | None:
    try:
        value = float(word.text.replace("_", "?"))  # Python reads 1_0 as 10
    except ValueError:
        report.add(word, f"'{word.text}' is not a number of seconds")
        return None
    if not abs(value) <= MOST_S:
        report.add(word, f"{word.text} is not between -{MOST_S:g} and {MOST_S:g} s")
        return None
    if least_delay_s is not None and value < -least_delay_s:
        report.add(
            word,
            f"{word.text} s takes more off than the delay of {least_delay_s:g} s: nothing arrives before it is sent; "
            "numbers here are what is added to the delay",
        )
        return None
    return value
