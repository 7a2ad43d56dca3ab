"""Which entry each comment of a YAML text belongs to.

A comment behind something belongs to that; one in a line of its own to what follows it, unless it is indented further:
then it closes what it is indented as. What stands before the first key stays at the file's top, and what stands after
the last at its end.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass
from typing import Final

from waypointctl.mission.layout.nodes import Entry, Line, Node, Scalar, walk

_COMMENT: Final = re.compile(r"(?:(?<=[ \t\n])|\A)#.*")


@dataclass(frozen=True, slots=True)
class Around:
    """The comments that are the file's own.

    Attributes:
        top: before the first key.
        end: after the last.
        apart: whether a blank line stands between the top and the first key.
    """

    top: list[Line]
    end: list[Line]
    apart: bool


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment: its text, where it begins in the whole text and in its line, and what else is in that."""

    text: str
    start: int
    column: int
    alone: bool
    behind_dash: bool = False
    blank_before: bool = False


def comments_of(text: str, root: Node) -> list[Comment]:
    """Return the comments of a text, in order; those behind the | of a block among them."""
    found, at = [], 0
    for begin, end, header_comment in (*_spans(root), (len(text), len(text), "")):
        for match in _COMMENT.finditer(text, at, begin):
            found.append(_comment(text, match.start(), match.group().rstrip()))
        if header_comment:
            found.append(Comment(header_comment, begin + 1, -1, alone=False))
        at = end
    return found


def _spans(root: Node) -> list[tuple[int, int, str]]:
    """Return where each scalar and key begins and ends, in order: what looks like a comment there is none."""
    entries = list(walk(root))
    nodes = [root, *(entry.node for entry in entries)]
    spans = [(node.start, node.end, node.header_comment) for node in nodes if isinstance(node, Scalar)]
    spans += [(entry.start, entry.start + len(entry.key), "") for entry in entries if entry.key is not None]
    return sorted(spans)


def attach_comments(text: str, root: Node) -> Around:
    """Give each comment and blank line of a text to the entry that it belongs to; return those of the file itself."""
    entries = list(walk(root))
    starts = [entry.start for entry in entries]
    for entry in entries:
        entry.blank_before = _blank_before(text, entry.start)
    around = Around([], [], apart=bool(entries) and entries[0].blank_before)
    if entries:
        entries[0].blank_before = False
    for comment in comments_of(text, root):
        at = bisect_right(starts, comment.start)
        if at == 0:
            around.top.append(Line(comment.text, comment.blank_before))
        elif comment.behind_dash and at < len(entries):
            entries[at].leading.append(Line(comment.text, blank_before=False))
        elif comment.alone:
            following = entries[at] if at < len(entries) else None
            _lines_for(comment, entries[at - 1], following, around).append(Line(comment.text, comment.blank_before))
        else:
            _out_of_closed(comment, entries[at - 1]).trailing.append(comment.text)
    return around


def _lines_for(comment: Comment, before: Entry, after: Entry | None, around: Around) -> list[Line]:
    """Return where a comment in a line of its own goes."""
    if after is not None and _leads(comment, before, after):
        return after.leading
    entry = _out_of_closed(comment, before)
    if after is None and comment.column == 0 and not _within_flow(comment, entry):
        return around.end
    while entry.owner is not None and entry.column > comment.column and not _within_flow(comment, entry):
        entry = entry.owner
    if entry.owner is not None or _within_flow(comment, entry):
        return entry.after
    return around.end if after is None else after.leading


def _leads(comment: Comment, before: Entry, after: Entry) -> bool:
    """Tell whether a comment is about the entry after it, and not about the end of what is before it."""
    if after.holder.is_flow and after.holder.start < comment.start:
        return True
    if _within_flow(comment, _out_of_closed(comment, before)):
        return False
    return after.owner is before or comment.column <= after.column


def _out_of_closed(comment: Comment, entry: Entry) -> Entry:
    """Return an entry, or the one around it whose braces are closed before the comment."""
    while entry.owner is not None and entry.holder.is_flow and entry.holder.end <= comment.start:
        entry = entry.owner
    return entry


def _within_flow(comment: Comment, entry: Entry) -> bool:
    return entry.holder.is_flow and entry.holder.start < comment.start < entry.holder.end


def _comment(text: str, start: int, content: str) -> Comment:
    line_start = text.rfind("\n", 0, start) + 1
    before = text[line_start:start].strip()
    blank_before = not before and _blank_before(text, start)
    return Comment(
        content, start, start - line_start, not before, bool(before) and not before.strip("- "), blank_before
    )


def _blank_before(text: str, start: int) -> bool:
    """Tell whether the line before the one of a place is blank."""
    line_start = text.rfind("\n", 0, start) + 1
    if not line_start:
        return False
    return not text[text.rfind("\n", 0, line_start - 1) + 1 : line_start].strip()
