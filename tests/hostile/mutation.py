"""Damage, drawn from a seed: to bytes, to what JSON says, and to what kind of file a name stands for."""

from __future__ import annotations

import copy
import os
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

SECRET: Final = "nobody-gave-this-file"  # what a link out of a folder leads to

NASTY: Final[tuple[Any, ...]] = (
    None, True, "", [], {}, -1, 0, 1, 2, 1e308, -1e-308, 10**18, 10**30, 10**400, float("nan"), float("inf"), "NaN",
    [1, 2, 3], ["a"], {"": 0}, 0.5, "1e999", "../..", "/dev/zero",
    "\x1b[2J\x1b]0;title\x07", "\u202eevil", "a\nb", "\ud800", "x" * 100_000, [[]] * 1000, {"a": {"b": {"c": []}}},
)  # fmt: skip


def damaged(rng: random.Random, content: bytes) -> bytes:
    """Return bytes with some of them changed, left out, doubled or made up."""
    for _ in range(rng.choice((1, 1, 2, 8, 64))):
        at = rng.randrange(len(content) + 1)
        length = rng.choice((1, 1, 4, 100, 5000))
        match rng.randrange(5):
            case 0:
                content = content[:at] + rng.randbytes(min(length, len(content) - at)) + content[at + length :]
            case 1:
                content = content[:at] + content[at + length :]
            case 2:
                content = content[:at] + content[at : at + length] * 2 + content[at + length :]
            case 3:
                content = content[:at] + bytes([rng.choice((0, 255, 127, 128))]) * length + content[at + length :]
            case _:
                content = content[:at] if rng.random() < 0.3 else content
    return content


def reworded(rng: random.Random, saying: Any) -> Any:
    """Return plain data in which one or more values are others, left out or added."""
    saying = copy.deepcopy(saying)
    for _ in range(rng.choice((1, 1, 2, 5))):
        holder, key = rng.choice(list(_places(saying)) or [({}, "")])
        match rng.randrange(4):
            case 0:
                holder.pop(key)
            case 1 if isinstance(holder, dict):
                holder[rng.choice(("extra", "\x1b[31m", "__proto__"))] = rng.choice(NASTY)
            case _:
                holder[key] = rng.choice(NASTY)
        if not saying:
            break
    return saying


def _places(saying: Any) -> Any:
    """Yield each list or object in plain data with each of its keys."""
    keys = list(saying) if isinstance(saying, dict) else range(len(saying)) if isinstance(saying, list) else ()
    for key in keys:
        yield saying, key
        yield from _places(saying[key])


def _outside(path: Path) -> None:
    secret = path.parent.parent / f"{SECRET}.txt"
    secret.write_text(f"{SECRET}\n")
    path.symlink_to(secret)


def _empty(path: Path) -> None:
    path.write_bytes(b"")


def _sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(2**40)


KINDS: Final[dict[str, Callable[[Path], None]]] = {
    "zeros": lambda path: path.symlink_to("/dev/zero"),
    "random numbers": lambda path: path.symlink_to("/dev/urandom"),
    "null": lambda path: path.symlink_to("/dev/null"),
    "pipe": lambda path: os.mkfifo(path),
    "folder": lambda path: path.mkdir(),
    "loop": lambda path: path.symlink_to(path.name),
    "dangling": lambda path: path.symlink_to("nowhere"),
    "outside": _outside,
    "sparse": _sparse,
    "empty": _empty,
    "memory": lambda path: path.symlink_to("/proc/self/mem"),
}


def of_another_kind(rng: random.Random, path: Path) -> str:
    """Put something else in the place of a file; return what."""
    kind = rng.choice(sorted(KINDS))
    path.unlink(missing_ok=True)
    KINDS[kind](path)
    return kind
