"""`waypointctl fmt`: a mission file through ruamel.yaml's round trip, its keys in the model's order.

Scalars keep their spelling, quotes, units and comments. Keys of a block mapping are reordered as lines of text, so that
a comment moves with the key below it; keys in braces are reordered as data. What the round trip cannot keep, such as a
comment within braces, is found by comparing the result with the source, and the file is refused.
"""

from __future__ import annotations

import io
import re
from codecs import BOM_UTF8
from collections.abc import Mapping, Sequence
from typing import Any, Final

from pydantic.fields import FieldInfo
from ruamel.yaml import YAML
from ruamel.yaml.comments import CommentedMap, CommentedSeq
from ruamel.yaml.error import YAMLError
from ruamel.yaml.resolver import VersionedResolver

from waypointctl.errors import MissionError
from waypointctl.mission.file_model import FileModel, model_in
from waypointctl.mission.mission import Mission
from waypointctl.mission.yaml_source import examine
from waypointctl.mission.yaml_tree import YamlFault, read_tree

MAX_BYTES: Final = 256 << 10  # the round trip takes about 0.1 s for 1 KiB of numbers
_LINE_BREAK: Final = re.compile("\r\n?")
_INDENT: Final = 2
_MOST_ROUNDS: Final = 4  # a comment can move once more when the keys around it have moved


def formatted(source: bytes, where: str) -> bytes:
    """Return a mission file's text in its one format; formatting that again changes nothing.

    Args:
        source: the file's text, of at most `MAX_BYTES`.
        where: its name, for messages.

    Raises:
        MissionError: it is not a mission, with everything that is wrong with it; or formatting would change what it
            says or lose a comment.
    """
    examine(source, where, Mission).value(MissionError)
    text = _LINE_BREAK.sub("\n", source.removeprefix(BOM_UTF8).decode())
    written = _settled(text)
    if written is None or not _says_the_same(text, written):
        problem = "formatting would lose a comment or change a value; the file is unchanged"
        hint = "Write comments on lines of their own and outside braces, and long texts in double quotes."
        raise MissionError(problem, where=where, hint=hint)
    return written.encode()


def quoted(text: str) -> str:
    """Return a text as a YAML scalar in double quotes."""
    named = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t"}
    return f'"{"".join(named.get(sign) or (sign if sign.isprintable() else _escaped(sign)) for sign in text)}"'


def _escaped(sign: str) -> str:
    code = ord(sign)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def _settled(text: str) -> str | None:
    """Return a text that the round trip leaves as it is; None where there is none within a few rounds."""
    for _ in range(_MOST_ROUNDS):
        before = text
        try:
            text = _round_trip(before)
        except (YAMLError, NotImplementedError, AssertionError, LookupError, ValueError):
            return None  # ruamel raises these of comments in places that it does not expect
        if text == before:
            return text
    return None


def _round_trip(text: str) -> str:
    yaml = _round_trip_yaml()
    data = yaml.load(text)
    lines = text.split("\n")
    _sort_lines(data, Mission, lines, len(lines))
    if (ordered := "\n".join(lines)) != text:
        data = yaml.load(ordered)
    _sort_braces(data, Mission)
    stream = io.StringIO()
    yaml.dump(data, stream)
    return stream.getvalue()


class _TextResolver(VersionedResolver):
    """Takes every scalar for text, so that each is written as it was read."""

    @property
    def versioned_resolver(self) -> dict[str, Any]:
        """No pattern makes a scalar something else."""
        return {}


def _round_trip_yaml() -> YAML:
    yaml = YAML()
    yaml.Resolver = _TextResolver
    yaml.preserve_quotes = True
    yaml.width = 2**20  # never fold a text
    yaml.indent(mapping=_INDENT, sequence=2 * _INDENT, offset=_INDENT)
    return yaml


def _says_the_same(text: str, written: str) -> bool:
    try:
        return text.count("#") == written.count("#") and _data(text) == _data(written)
    except YamlFault:
        return False


def _data(text: str) -> Any:
    return read_tree(text.encode()).data


def _sort_lines(node: Any, model: type[FileModel] | None, lines: list[str], end: int) -> None:
    """Bring the keys of block mappings into their models' order, in place, the innermost first.

    Args:
        node: a part of the data.
        model: of that part.
        lines: of the whole text; sorting moves lines, but their number stays.
        end: index of the first line after the node.
    """
    if not isinstance(node, CommentedMap | CommentedSeq) or node.fa.flow_style() or not node:
        return
    places = [(key, *_place(node, key)) for key in (node if isinstance(node, CommentedMap) else range(len(node)))]
    begins = [line if at == 0 else _first_leading(lines, line, column) for at, (_, line, column) in enumerate(places)]
    ends = [*begins[1:], end]
    for (key, _, _), entry_end in zip(places, ends, strict=True):
        _sort_lines(node[key], _model_at(model, key), lines, entry_end)
    keys = [key for key, _, _ in places]
    if isinstance(node, CommentedMap) and model is not None and (wanted := _in_order(keys, model)) != keys:
        # At the end, a comment as far left as the keys may be the file's own: it stays.
        ends[-1] = _first_leading(lines, end, places[-1][2])
        first, column = places[0][1:]
        prefix, lines[first] = lines[first][:column], " " * column + lines[first][column:]
        blocks = {key: lines[begin:stop] for key, begin, stop in zip(keys, begins, ends, strict=True)}
        key_lines = {key: line - begin for (key, line, _), begin in zip(places, begins, strict=True)}
        lines[begins[0] : ends[-1]] = [line for key in wanted for line in blocks[key]]
        at = begins[0] + key_lines[wanted[0]]
        lines[at] = prefix + lines[at][column:]


def _place(node: CommentedMap | CommentedSeq, key: Any) -> tuple[int, int]:
    """Return the line and column, from 0, of a key, or of a list's element with its dash."""
    line, column = node.lc.key(key) if isinstance(node, CommentedMap) else (node.lc.item(key)[0], node.lc.col)
    return line, column


def _first_leading(lines: Sequence[str], line: int, column: int) -> int:
    """Return the first of the blank lines and comments above a line that belong to what is there."""
    while line and (not lines[line - 1].strip() or lines[line - 1].startswith(" " * column + "#")):
        line -= 1
    return line


def _sort_braces(node: Any, model: type[FileModel] | None) -> None:
    """Bring the keys of mappings in braces into their models' order, in place."""
    if isinstance(node, CommentedMap):
        if model is not None and node.fa.flow_style():
            for key in _in_order(list(node), model):
                node.move_to_end(key)
        for key, value in node.items():
            _sort_braces(value, _model_at(model, key))
    elif isinstance(node, CommentedSeq):
        for value in node:
            _sort_braces(value, model)


def _in_order(keys: list[Any], model: type[FileModel]) -> list[Any]:
    ranks = _ranks(model)
    return sorted(keys, key=lambda key: ranks.get(key, len(ranks)))


def _ranks(model: type[FileModel]) -> Mapping[str, int]:
    """Return the place of each key that a model reads; those that are for each of several fields come last."""
    fields = list(model.model_fields)
    ranks = {name: rank for rank, name in enumerate(fields)}
    ranks |= {bare: ranks[name] for bare, name in model.bare_names().items()}
    shared = model.shared_model()
    if shared is not None:
        ranks |= {key: rank + len(fields) for key, rank in _ranks(shared).items() if key not in ranks}
    return ranks


def _model_at(model: type[FileModel] | None, key: str | int) -> type[FileModel] | None:
    """Return the model of a key's value, or of an element of a list."""
    return model if model is None or isinstance(key, int) else model_in(getattr(_field(model, key), "annotation", None))


def _field(model: type[FileModel], key: str) -> FieldInfo | None:
    name = model.bare_names().get(key, key)
    if name in model.model_fields:
        return model.model_fields[name]
    shared = model.shared_model()
    return None if shared is None else _field(shared, key)
