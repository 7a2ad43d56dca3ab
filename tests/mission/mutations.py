"""Missions altered at random: bytes, tokens, values, structure, escapes, numbers, nesting and references."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable
from typing import Any, Final

from waypointctl.mission.yaml_tree import YamlFault, read_tree

Mutation = Callable[[bytes, random.Random], bytes]

_SCALAR: Final = re.compile(rb"(?<=[:\[,-] )[^\s,\[\]{}#][^,\[\]{}#\n]*")
_TOKEN: Final = re.compile(rb"[A-Za-z_]+|[-+.0-9eE]+|[^\sA-Za-z0-9]|\s+")
_NUMBERS: Final = (
    *("0", "-0.0", "-1", "1e-320", "1e308", "1e309", "-1e400", ".nan", ".inf", "-.inf", "9" * 18, "9" * 30),
    *("9" * 500, "0x7fffffffffffffff", "0o777", "1_000", "2147483648", "9223372036854775807", "1.5", "1e-9", "100000"),
)
_UNITS: Final = (
    "",
    " s",
    " ms",
    " ns",
    " min",
    " h",
    " d",
    " m",
    " km",
    " mm",
    " deg",
    " rad",
    " Hz",
    " kbit/s",
    " %",
    " ft",
)
_WORDS: Final = (
    *(
        "null",
        "~",
        "true",
        "False",
        "all",
        "mission",
        "waypoint",
        "short_range_goal",
        "joint",
        "abort",
        "skip",
        "hold",
        "home",
    ),
    *("return_home", "release", "cancel", "go_to", "set_timeout", "box", "radius", "moon", "mars", "leo", "continuous"),
)
_ESCAPES: Final = (
    *(r'"\UFFFFFFFF"', r'"\U0010FFFF"', r'"\uD800"', r'"\x1b[2J"', r'"\0"', r'"\q"', r'"\u202e"', r'"\N\_\L\P"', '"'),
    *(
        "'",
        "'''",
        "|",
        ">-",
        "&a x",
        "*a",
        "!!python/object:os.system x",
        "!<%FF> x",
        "<<: x",
        "? x",
        "@x",
        "`x`",
        "%x",
    ),
)
_FILES: Final = (
    *("/dev/zero", "/dev/stdin", "/dev/null", "/proc/self/mem", "..", ".", "../..", "/", "~", "nowhere", "a\\0b"),
    *("contact-plan.ionrc", "long-tail.jitter.txt", "patrol.yaml", "x" * 300, "./././contact-plan.ionrc", "C:\\\\x"),
)
_KEYS: Final = (
    *("name", "seed", "robot", "policy", "start", "waypoints", "defaults", "link", "autonomy", "operator", "onboard"),
    *(
        "commands",
        "schedule",
        "expect",
        "telemetry",
        "position",
        "position_m",
        "tolerance",
        "timeout",
        "hold",
        "repeat",
    ),
    *("delay", "delay_s", "jitter", "jitter_file", "loss", "windows", "windows_period", "contact_plan", "file", "rate"),
    *(
        "up",
        "down",
        "preset",
        "delay_table",
        "duplicate",
        "queue",
        "geofence",
        "keep_in",
        "keep_out",
        "corners",
        "center",
    ),
)


def mutated(source: bytes, rng: random.Random) -> bytes:
    """Return a mission's text with one to four things altered."""
    for _ in range(rng.choice((1, 1, 2, 3, 4))):
        source = rng.choice(MUTATIONS)(source, rng)
    return source


def _at(source: bytes, rng: random.Random) -> int:
    return rng.randrange(len(source) + 1)


def flip_bit(source: bytes, rng: random.Random) -> bytes:
    """Flip a bit."""
    at = _at(source, rng)
    return source[:at] + bytes(byte ^ (1 << rng.randrange(8)) for byte in source[at : at + 1]) + source[at + 1 :]


def put_bytes(source: bytes, rng: random.Random) -> bytes:
    """Insert bytes that mean something to somebody."""
    at = _at(source, rng)
    odd = (
        b"\x00",
        b"\xff",
        b"\xc3",
        b"\xed\xa0\x80",
        b"\xef\xbb\xbf",
        b"\r",
        b"\t",
        b"\x85",
        b"\x1b[2J",
        b"\xe2\x80\xae",
    )
    return source[:at] + rng.choice((*odd, rng.randbytes(rng.randrange(1, 5)))) + source[at:]


def cut(source: bytes, rng: random.Random) -> bytes:
    """Take a stretch out, or everything from somewhere on."""
    begin, end = sorted((_at(source, rng), _at(source, rng)))
    return source[:begin] if rng.random() < 0.2 else source[:begin] + source[min(end, begin + 40) :]


def repeat_stretch(source: bytes, rng: random.Random) -> bytes:
    """Repeat a stretch, a few or many times."""
    begin = _at(source, rng)
    stretch = source[begin : begin + rng.randrange(1, 60)]
    return source[:begin] + stretch * rng.choice((1, 2, 10, 1000)) + source[begin:]


def swap_lines(source: bytes, rng: random.Random) -> bytes:
    """Swap two lines."""
    lines = source.split(b"\n")
    one, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[one], lines[other] = lines[other], lines[one]
    return b"\n".join(lines)


def move_in(source: bytes, rng: random.Random) -> bytes:
    """Indent a line otherwise."""
    lines = source.split(b"\n")
    at = rng.randrange(len(lines))
    lines[at] = rng.choice((b"", b" ", b"  ", b"   ", b"\t", b" " * 200)) + lines[at].lstrip()
    return b"\n".join(lines)


def swap_tokens(source: bytes, rng: random.Random) -> bytes:
    """Put one token in the place of another."""
    tokens = _TOKEN.findall(source)
    if not tokens:
        return source
    tokens[rng.randrange(len(tokens))] = rng.choice(tokens)
    return b"".join(tokens)


def rename_key(source: bytes, rng: random.Random) -> bytes:
    """Write another key in the place of a word."""
    words = list(re.finditer(rb"[a-z_]+(?=:)", source))
    if not words:
        return source
    found = rng.choice(words)
    return source[: found.start()] + rng.choice(_KEYS).encode() + source[found.end() :]


def replace_value(source: bytes, rng: random.Random) -> bytes:
    """Write something else where a value stands."""
    values = list(_SCALAR.finditer(source))
    if not values:
        return source
    found = rng.choice(values)
    return source[: found.start()] + _value(rng).encode() + source[found.end() :]


def _value(rng: random.Random) -> str:
    kind = rng.randrange(6)
    if kind == 0:
        return rng.choice(_WORDS)
    if kind == 1:
        return rng.choice(_ESCAPES)
    if kind == 2:
        return rng.choice(_FILES)
    if kind == 3:
        return rng.choice(
            ("[]", "{}", "[[]]", "[1, 2, 3]", "{x: 1}", "[" * 30 + "]" * 30, "{a: " * 25 + "}" * 25, "x" * 5000)
        )
    return f"{rng.choice(_NUMBERS)}{rng.choice(_UNITS)}"


def reshape(source: bytes, rng: random.Random) -> bytes:
    """Alter the data: take a part out, repeat it, put it elsewhere, nest it, or give it another type."""
    try:
        data = read_tree(source).data
    except YamlFault:
        return source
    places = list(_places(data))
    if not places:
        return source
    container, key = rng.choice(places)
    other, elsewhere = rng.choice(places)
    part: Any = container[key]
    kind = rng.randrange(6)
    if kind == 0:
        del container[key]
    elif kind == 1:
        container[key] = [part] * rng.choice((0, 2, 3, 1200))
    elif kind == 2:
        container[key] = json.loads(json.dumps(other[elsewhere]))
    elif kind == 3:
        container[key] = {str(rng.choice(_KEYS)): part}
    elif kind == 4 and isinstance(part, list):
        container[key] = part * rng.choice((2, 30, 400))
    else:
        container[key] = rng.choice((None, True, 0, -1, 10**25, 1e308, "", "x", [], {}, [part], f"{part}"))
    return json.dumps(data, ensure_ascii=rng.random() < 0.5).encode(errors="surrogatepass")


def _places(data: Any) -> list[tuple[Any, Any]]:
    """Return every container of a file's data with each of its keys."""
    found: list[tuple[Any, Any]] = []
    rest = [data]
    while rest:
        part = rest.pop()
        keys = list(part) if isinstance(part, dict) else range(len(part)) if isinstance(part, list) else ()
        found += [(part, key) for key in keys]
        rest += [part[key] for key in keys]
    return found


MUTATIONS: Final[tuple[Mutation, ...]] = (
    *(flip_bit, put_bytes, cut, repeat_stretch, swap_lines, move_in, swap_tokens, rename_key),
    *(replace_value, replace_value, replace_value, reshape, reshape),
)
