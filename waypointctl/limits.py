"""How much is read of files that others wrote, and how `waypointctl --limit NAME=VALUE` changes it.

A limit holds for this process and those that it starts: it is kept in the environment.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

VARIABLE: Final = "WAYPOINTCTL_LIMITS"

_KIB, _MIB, _GIB = 2**10, 2**20, 2**30
_UNITS: Final = {"B": 1, "KiB": _KIB, "MiB": _MIB, "GiB": _GIB}
_VALUE: Final = re.compile(r"([0-9]{1,18})\s*([A-Za-z]*)")


@dataclass(frozen=True, slots=True)
class Limit:
    """The most that is read of something.

    Attributes:
        default: in bytes, or a count.
        of: what it limits, for people.
        is_size: whether it is in bytes.
    """

    default: int
    of: str
    is_size: bool = True

    def text(self, value: int) -> str:
        """Return a value with its unit."""
        return size_text(value) if self.is_size else f"{value:,}"


LIMITS: Final = {
    "policy-file": Limit(48 * _MIB, "a policy's policy.onnx, and its weights.safetensors"),
    "policy-work": Limit(2**33, "multiplications of a policy's network for 256 observations", is_size=False),
    "log-record": Limit(64 * _MIB, "a record of a log's file: an attachment, a chunk as it is compressed"),
    "log-attachments": Limit(128 * _MIB, "the attachments of a log together"),
    "log-metadata": Limit(4 * _MIB, "metadata, schemas and channels of a log together"),
    "log-entries": Limit(1_000, "attachments of a log; entries of its metadata, schemas and channels", is_size=False),
    "log-chunk": Limit(32 * _MIB, "what a chunk of a log unpacks to"),
    "log-expansion": Limit(100, "what a log's chunks unpack to together, in sizes of its file", is_size=False),
    "log-messages": Limit(100_000, "messages of a log beyond one for each 16 bytes of its file", is_size=False),
    "model-elements": Limit(2_000, "elements of a robot's MJCF", is_size=False),
    "robot-files": Limit(24 * _MIB, "a robot's MJCF, with what it includes, its meshes and textures"),
    "sb3-archive": Limit(256 * _MIB, "a file of stable-baselines3, what its parts unpack to, and its tensors"),
}


def limit(name: str) -> int:
    """Return the limit in force: the default, or what `--limit` has set.

    Raises:
        ValueError: the environment's value of `VARIABLE` is not what `set_limits` writes.
    """
    return _given(os.environ.get(VARIABLE, "")).get(name, LIMITS[name].default)


def set_limits(texts: Sequence[str]) -> None:
    """Set limits from texts such as "policy-file=256MiB", for this process and those that it starts.

    Raises:
        ValueError: there is no such limit, or its value is invalid.
    """
    given = _given(os.environ.get(VARIABLE, "")) | dict(_limit(text) for text in texts)
    if given:
        os.environ[VARIABLE] = ",".join(f"{name}={value}" for name, value in given.items())


def over_limit(name: str, found: int, what: str = "") -> str:
    """Return what is wrong with an input of which `found`, a size [bytes] or a count, is over a limit."""
    text = _rounded_up(found) if LIMITS[name].is_size else f"{found:,}"
    return f"has {text}{what and ' '}{what}; the limit {name} is {LIMITS[name].text(limit(name))}"


def limit_hint(name: str, needed: int | None = None) -> str:
    """Return what to do about an input that is over a limit.

    Args:
        name: of the limit.
        needed: a value that is enough, where it is known. The next power of two is named, which has a short text.
    """
    enough = 2 * limit(name) if needed is None else 1 << (needed - 1).bit_length()
    value = LIMITS[name].text(enough).replace(" ", "").replace(",", "")
    return f"if you trust its source, raise the limit: `waypointctl --limit {name}={value} COMMAND ...`"


def size_text(size: int) -> str:
    """Return a size in the largest unit that it is a whole number of, such as "64 MiB"."""
    unit = next(unit for unit in reversed(_UNITS) if size % _UNITS[unit] == 0)
    return f"{size // _UNITS[unit]} {unit}"


def _rounded_up(size: int) -> str:
    """Return a size in the largest unit of which it has ten or more, rounded up."""
    unit = next((unit for unit in reversed(_UNITS) if size >= 10 * _UNITS[unit]), "B")
    return f"{-(-size // _UNITS[unit]):,} {unit}"


def _given(text: str) -> dict[str, int]:
    return dict(_limit(part) for part in text.split(",") if part)


def _limit(text: str) -> tuple[str, int]:
    name, _, value = text.partition("=")
    if name not in LIMITS:
        raise ValueError(f"there is no limit {name[:40]!r}; there are: {', '.join(LIMITS)}")
    units = _UNITS if LIMITS[name].is_size else {"": 1}
    match = _VALUE.fullmatch(value)
    number, unit = (int(match[1]), match[2] or next(iter(units))) if match else (0, "")  # a bare size is in bytes
    if unit not in units or not number:
        allowed = "a size such as 256MiB or 1GiB" if LIMITS[name].is_size else "a whole number above 0"
        raise ValueError(f"{text[:60]!r}: expected {allowed}")
    return name, number * units[unit]
