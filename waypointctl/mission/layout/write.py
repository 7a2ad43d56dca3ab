"""The nodes of a YAML text written in the one layout: two spaces a level, and in one line what is small and flat."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

from waypointctl.mission.layout.comments import Around
from waypointctl.mission.layout.nodes import Collection, Entry, Line, Node, Scalar

WIDTH: Final = 120
_STEP: Final = 2
_FLOW_SIGNS: Final = frozenset(",[]{}")


def write_nodes(root: Node, around: Around, text: str) -> str:
    """Return a whole text.

    Args:
        root: its nodes.
        around: the file's own comments.
        text: that the nodes were read from.
    """
    lines = list(_comment_lines(around.top, 0))
    if isinstance(root, Collection) and root.entries:
        lines += _top_entries(root.entries, text, apart=around.apart and bool(lines))
    else:
        lines.append(_inline(root) or "")
    lines += _comment_lines(around.end, 0)
    while lines and not lines[0]:
        del lines[0]
    return "".join(f"{line}\n" for line in lines)


def _top_entries(entries: Sequence[Entry], text: str, *, apart: bool) -> Iterator[str]:
    """Yield the lines of the entries at the top; one that takes several has blank lines around it.

    With `apart` the first has a blank line before it.
    """
    was_tall = False
    for place, entry in enumerate(entries):
        is_tall = _in_one_line(entry, 0) is None and isinstance(entry.node, Collection)
        if place == 0 or is_tall or was_tall:
            _set_apart(entry, place > 0 or apart)
        yield from _entry(entry, 0, text)
        was_tall = is_tall


def _set_apart(entry: Entry, apart: bool) -> None:
    """Let a blank line stand before an entry and its comments, or not."""
    if entry.leading:
        entry.leading[0] = Line(entry.leading[0].text, blank_before=apart)
    else:
        entry.blank_before = apart


def _entry(entry: Entry, indent: int, text: str) -> Iterator[str]:
    """Yield the lines of an entry; the first is blank where one stood before it."""
    node = entry.node
    one_line = _in_one_line(entry, indent)
    leading, trailing = [*entry.leading, *_up_front(entry, one_line)], entry.trailing[-1:]
    if one_line is None and entry.key is None and isinstance(node, Collection):
        leading, trailing = [*leading, *(Line(comment, False) for comment in trailing)], []
    yield from _comment_lines(leading, indent)
    if entry.blank_before:
        yield ""
    head = " " * indent + ("-" if entry.key is None else f"{entry.key}:")
    comment = f" {trailing[0]}" if trailing else ""
    if one_line is not None:
        yield f"{head}{' ' if one_line else ''}{one_line}{comment}"
    elif isinstance(node, Scalar):
        yield from _tall_scalar(node, head, indent, comment, text)
    else:
        yield from _block(entry, node, head + comment, indent, text)
    yield from _comment_lines(entry.after, indent)


def _up_front(entry: Entry, one_line: str | None) -> Iterator[Line]:
    """Yield the comments that cannot stay where they are: all but one of a line, and those behind a lone dash."""
    for comment in entry.trailing[:-1]:
        yield Line(comment, False)
    if one_line is None and entry.key is None and isinstance(entry.node, Collection) and entry.node.is_mapping:
        yield from entry.node.entries[0].leading  # the first key goes behind the dash


def _block(entry: Entry, node: Collection, head: str, indent: int, text: str) -> Iterator[str]:
    """Yield a collection with an entry a line; the first key of a list's element goes behind the dash."""
    first, *others = node.entries
    first.blank_before = False
    inner = indent + _STEP
    if entry.key is None and node.is_mapping:
        first.leading = []
        begin, *rest = _entry(first, inner, text)
        yield f"{head} {begin.lstrip()}"
        yield from rest
    else:
        yield head
        yield from _without_blank(_entry(first, inner, text))
    for other in others:
        yield from _entry(other, inner, text)


def _without_blank(lines: Iterator[str]) -> Iterator[str]:
    """Yield lines without a blank first one."""
    first = next(lines)
    if first:
        yield first
    yield from lines


def _comment_lines(comments: Sequence[Line], indent: int) -> Iterator[str]:
    for comment in comments:
        if comment.blank_before:
            yield ""
        yield " " * indent + comment.text


def _in_one_line(entry: Entry, indent: int) -> str | None:
    """Return the value of an entry as it goes in one line, None where it does not."""
    node = entry.node
    if isinstance(node, Scalar):
        return _inline(node)
    if not node.entries:
        return "{}" if node.is_mapping else "[]"
    outermost = entry.owner is None and (node.is_mapping or not _flat(node))
    if outermost or not _flat(node) or any(inner.has_comments for inner in node.entries):
        return None
    if entry.owner is None and any(isinstance(inner.node, Collection) for inner in node.entries):
        return None  # a list of places at the top: one a line
    flow = _flow(node)
    before = indent + _STEP + len(entry.key or "")
    return flow if flow is not None and before + len(flow) <= WIDTH else None


def _flat(node: Collection) -> bool:
    """Tell whether there is no mapping in a collection, at any depth."""
    inner = [entry.node for entry in node.entries if isinstance(entry.node, Collection)]
    return all(not each.is_mapping and _flat(each) for each in inner)


def _flow(node: Node) -> str | None:
    """Return a node in braces and brackets, None where one of its scalars would mean something else there."""
    if isinstance(node, Scalar):
        text = _inline(node)
        return None if not text or (node.style is None and _FLOW_SIGNS & set(text)) else text
    parts = []
    for entry in node.entries:
        part = _flow(entry.node)
        if part is None or (entry.key is not None and entry.key[0] not in "'\"" and _FLOW_SIGNS & set(entry.key)):
            return None
        parts.append(part if entry.key is None else f"{entry.key}: {part}")
    inside = ", ".join(parts)
    return f"{{{inside}}}" if node.is_mapping else f"[{inside}]"


def _inline(node: Node) -> str | None:
    """Return a scalar in one line, as it is written where that is one; None for a block that stays one."""
    if not isinstance(node, Scalar):
        return "{}" if node.is_mapping else "[]"
    if node.text is not None:
        return node.text
    if node.style is None:
        return node.value if "\n" not in node.value else quoted(node.value)
    return None if _stays_block(node) else quoted(node.value)


def _stays_block(node: Scalar) -> bool:
    # Where the first line begins with a space, or blank lines at the end count, a block's look misleads.
    plain_shape = node.value[:1] not in ("", " ", "\n") and not node.value.endswith("\n\n")
    return node.style in ("|", ">") and plain_shape and "\t" not in node.value


def _tall_scalar(node: Scalar, head: str, indent: int, comment: str, text: str) -> Iterator[str]:
    """Yield a block scalar with its lines moved to where they belong."""
    chomping = "" if node.value.endswith("\n") else "-"
    yield f"{head} {node.style}{chomping}{comment}"
    lines = [line.rstrip("\r") for line in text[node.start : node.end].split("\n")[1:]]
    while lines and not lines[-1].strip():
        lines.pop()
    written = next(len(line) - len(line.lstrip(" ")) for line in lines if line.strip())
    for line in lines:
        yield " " * (indent + _STEP) + line[written:] if line[written:] else ""


def quoted(value: str) -> str:
    """Return a text in double quotes."""
    named = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}
    return f'"{"".join(named.get(sign) or (sign if sign.isprintable() else _escaped(sign)) for sign in value)}"'


def _escaped(sign: str) -> str:
    code = ord(sign)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
