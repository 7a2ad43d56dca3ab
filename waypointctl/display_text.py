r"""Text from files, names and people, made fit to show: on a terminal, in a report, in a picture.

A name can hold what steers a terminal (escape sequences, control characters), what reorders a line (bidirectional
controls), what breaks it, or what nobody sees (zero-width characters, halves of surrogate pairs). Each of these is
shown as JSON escapes it, such as \u001b, so that JSON that passes through here stays the same JSON.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import unicodedata
from collections.abc import Iterable
from functools import lru_cache
from pathlib import Path
from typing import Final

MOST_CHARACTERS: Final = 1000  # shown of a line

_NOT_ASCII_PRINTABLE: Final = re.compile("[^ -~]")
_HIDDEN_CATEGORIES: Final = frozenset({"Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp"})
# Letters and marks that show nothing: Unicode's Default_Ignorable_Code_Point outside these categories.
_INVISIBLE: Final = re.compile(
    "[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u3164\ufe00-\ufe0f\uffa0\U000e0000-\U000e0fff]"
)


def printable(text: str | Path, most: int = MOST_CHARACTERS) -> str:
    """Return a text as one line of characters that can be seen, its middle left out where it is longer than `most`."""
    text = str(text)
    return _shortened(text, most) if text.isascii() and text.isprintable() else _shortened(_escaped(text), most)


def printable_lines(text: str) -> str:
    """Return a text of several lines with all that `printable` escapes but the line breaks, however long it is."""
    if text.isascii() and text.replace("\n", "").isprintable():
        return text
    return "\n".join(map(_escaped, text.split("\n")))


def shell_word(text: str | Path) -> str:
    """Return a text as a shell reads it back, for a command that people copy: a name with controls as $'...'."""
    text = str(text)
    if printable(text, len(text)) == text:
        return shlex.quote(text)
    plain = (chr(byte) if 0x20 <= byte < 0x7F and chr(byte) not in "\\'" else f"\\x{byte:02x}" for byte in _bytes(text))
    return f"$'{''.join(plain)}'"


def _bytes(text: str) -> bytes:
    try:
        return os.fsencode(text)
    except UnicodeEncodeError:  # half of a surrogate pair that no file name can have
        return text.encode(errors="replace")


def _escaped(text: str) -> str:
    return _NOT_ASCII_PRINTABLE.sub(lambda match: _visible(match.group()), text)


@lru_cache(maxsize=4096)
def _visible(character: str) -> str:
    """Return a character, or its escape where it cannot be seen."""
    if character == "\x7f":
        return r"\u007f"
    if unicodedata.category(character) in _HIDDEN_CATEGORIES or _INVISIBLE.match(character):
        return json.dumps(character)[1:-1]
    return character


def _shortened(text: str, most: int) -> str:
    if len(text) <= most:
        return text
    tail = most // 3  # a place ends in its line and column
    return f"{text[: most - tail]}...({len(text) - most:,} characters)...{text[len(text) - tail :]}"


_MAX_SHOWN: Final = 60


def shown(value: object) -> str:
    """Return a value as a message shows it: as the file would have it, and short."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    text = repr(value)
    return text if len(text) <= _MAX_SHOWN else f"{text[:_MAX_SHOWN]}..."


def path_text(path: Iterable[str | int]) -> str:
    """Return a path as "waypoints[2].name"; a key that is not a plain word is quoted."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            key = part if re.fullmatch(r"[\w-]+", part) else shown(part)
            text += f".{key}" if text else key
    return text


def counted(count: int, things: str) -> str:
    """Return how many there are: "1 number", "3 numbers"; the plural is given."""
    return f"{count} {things[:-1] if count == 1 else things}"
