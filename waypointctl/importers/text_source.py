"""Text that others write."""

from __future__ import annotations

from waypointctl.errors import MissionError
from waypointctl.importers.report import Report


def text_of(source: bytes, report: Report) -> str:
    """Return UTF-8 text, with or without a byte order mark.

    Raises:
        MissionError: it is not UTF-8, or is empty.
    """
    try:
        text = source.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = source.count(b"\n", 0, error.start) + 1
        problem = f"is not UTF-8 text: byte 0x{source[error.start]:02x}"
        raise MissionError(problem, where=f"{report.where}:{line}") from error
    if not text.strip():
        raise MissionError("is empty", where=report.where)
    return text
