"""A mission file in its one layout: keys in the model's order, comments, spellings and units as they were written."""

from __future__ import annotations

from codecs import BOM_UTF8

from waypointctl.errors import MissionError
from waypointctl.mission.layout.comments import attach_comments, comments_of
from waypointctl.mission.layout.key_order import sort_keys
from waypointctl.mission.layout.nodes import read_nodes
from waypointctl.mission.layout.write import write_nodes
from waypointctl.mission.mission import Mission
from waypointctl.mission.yaml_source import as_error, examine
from waypointctl.mission.yaml_tree import YamlFault, read_tree


def laid_out(source: bytes, where: str) -> bytes:
    """Return a mission file's text in its one layout; laid out again it stays the same.

    What is written is read back: it holds the very values and comments of what was given.

    Args:
        source: the file's text.
        where: its name, for messages.

    Raises:
        MissionError: it is not a mission, with everything that is wrong with it; or it is written in a way that could
            not be laid out without changing it.
    """
    reading = examine(source, where, Mission)
    if reading.model is None:
        raise as_error(reading.problems, MissionError)
    text = source.removeprefix(BOM_UTF8).decode().replace("\r\n", "\n").replace("\r", "\n")
    written = written_again(text)
    if not _says_the_same(text, written):
        problem = "is written in a way that could not be laid out without changing it; left as it is"
        raise MissionError(problem, where=where, hint="Write long texts in double quotes, and comments between keys.")
    return written.encode()


def written_again(text: str) -> str:
    """Return a mission's text in its one layout, without looking whether it still says the same."""
    root = read_nodes(text)
    around = attach_comments(text, root)
    sort_keys(root, Mission)
    return write_nodes(root, around, text)


def _says_the_same(text: str, written: str) -> bool:
    try:
        same = read_tree(text.encode()).data == read_tree(written.encode()).data
    except YamlFault:
        return False
    return same and _comments(text) == _comments(written)


def _comments(text: str) -> list[str]:
    return sorted(comment.text for comment in comments_of(text, read_nodes(text)))
