"""Reading MJCF that somebody else wrote, before MuJoCo does: what it may say, and how large it makes the model.

MuJoCo reads files that MJCF names (include, meshes, textures, height fields, plugins), and takes the memory that its
numbers ask for before it looks at them. Elements are therefore an allow-list, no attribute names a file, and counts
have limits. MuJoCo's parser is not this one: it is given the elements and attributes that were read here, written anew,
never the text. Elements and attributes: https://mujoco.readthedocs.io/en/stable/XMLreference.html.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from typing import Final
from xml.parsers import expat
from xml.sax.saxutils import quoteattr

from waypointctl.errors import InputError
from waypointctl.limits import limit, limit_hint, size_text

MOST_BYTES: Final = 2**20
MOST_DEPTH: Final = 64
MOST_JOINTS: Final = 128
MOST_MEMORY: Final = 2**26  # [bytes] that the model may ask for to work in
MOST_PIXELS: Final = 2**24  # of all textures and height fields together

_LIMIT: Final = "model-elements"

ELEMENTS: Final = frozenset(
    re.findall(
        r"\w+",
        """
        mujoco compiler option flag size statistic visual global quality headlight map scale rgba default asset texture
        material layer hfield worldbody body inertial joint freejoint geom site camera light frame contact pair exclude
        tendon spatial fixed pulley equality connect weld actuator general motor position velocity intvelocity damper
        cylinder adhesion custom numeric text tuple element keyframe key

        sensor touch accelerometer velocimeter gyro force torque magnetometer camprojection rangefinder jointpos
        jointvel tendonpos tendonvel actuatorpos actuatorvel actuatorfrc jointactuatorfrc tendonactuatorfrc ballquat
        ballangvel jointlimitpos jointlimitvel jointlimitfrc tendonlimitpos tendonlimitvel tendonlimitfrc framepos
        framequat framexaxis frameyaxis framezaxis framelinvel frameangvel framelinacc frameangacc subtreecom
        subtreelinvel subtreeangmom insidesite distance normal fromto e_potential e_kinetic clock user
        """,
    )
)
# Attributes that count something, and the most that they may count.
COUNTS: Final[Mapping[str, int]] = {
    **dict.fromkeys(("iterations", "ls_iterations", "noslip_iterations", "ccd_iterations", "sdf_iterations"), 1000),
    **dict.fromkeys(("sdf_initpoints", "nkey", "nsample", "dim", "actdim"), 1000),
    **dict.fromkeys(("nuser_actuator", "nuser_body", "nuser_cam", "nuser_geom", "nuser_jnt", "nuser_sensor"), 100),
    **dict.fromkeys(("nuser_site", "nuser_tendon", "numquads", "numslices", "numstacks"), 100),
    **dict.fromkeys(("nrow", "ncol", "width", "height", "offwidth", "offheight", "resolution", "shadowsize"), 4096),
    **dict.fromkeys(("offsamples", "nchannel", "gridsize"), 16),
    "nuserdata": 100_000,
}
_LENGTHS: Final = {("tendon", "width"), ("spatial", "width")}  # not a count here
_FILE: Final = re.compile(r"file\w*|\w+dir|plugin|content_type")  # an attribute that names a file, or where it is
_REFUSED: Final = {  # and why
    ("rangefinder", "camera"): "is not read: it casts a ray for each pixel",
    **{("size", name): "is not read; 'memory' says how much there is" for name in ("njmax", "nconmax", "nstack")},
}
_COUNT: Final = re.compile(r"-1|[0-9]{1,9}")
_KINDS: Final = ("dyntype", "gaintype", "biastype")
_MEMORY: Final = re.compile(r"-1|([0-9]{1,9})([KMG]?)")
_BYTES: Final = {"": 1, "K": 2**10, "M": 2**20, "G": 2**30}
_NO_NUMBER: Final = re.compile(r"[+-]?(nan(\(.*\))?|inf(inity)?)", re.IGNORECASE)


def audited_mjcf(source: bytes, where: str) -> str:
    """Return MJCF that says what `source` says to a parser of XML, once everything in it has been looked at.

    Args:
        source: the MJCF.
        where: its file, for messages.

    Raises:
        InputError: it is not MJCF, it names a file, it has what is not read here, or it is over a limit.
    """
    if len(source) > MOST_BYTES:
        raise InputError(f"has {len(source):,} bytes; {MOST_BYTES:,} are read", where=where)
    try:
        source.decode()
    except UnicodeDecodeError as error:
        raise InputError(f"is not UTF-8 text: byte {error.start}", where=where) from error
    audit = _Audit(where, source.count(b"<"))
    try:
        audit.parser.Parse(source, True)
    except expat.ExpatError as error:
        raise InputError(f"is not XML: {error}", where=where) from error
    return "".join(audit.written)


class _Audit:
    """Takes elements as they come, refuses what must not be, and writes down the others."""

    def __init__(self, where: str, most_elements: int) -> None:
        self._most_elements = most_elements
        self.written: list[str] = []
        self.parser = expat.ParserCreate("UTF-8")  # whatever encoding it declares, as MuJoCo does
        self.parser.StartDoctypeDeclHandler = self._doctype
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self._where = where
        self._depth = 0
        self._seen: Counter[str] = Counter()
        self._pixels = 0

    def _doctype(self, *_: object) -> None:
        raise self._refusal("a document type, which can define entities, is not read")

    def _start(self, name: str, attributes: Mapping[str, str]) -> None:
        self._seen[name] += 1
        self._depth += 1
        if self._depth == 1 and name != "mujoco":
            kind = "a URDF" if name == "robot" else "not MJCF"
            raise self._refusal(f"is {kind}: its root is <{name}>, that of MJCF is <mujoco>")
        if name not in ELEMENTS:
            raise self._refusal(f"<{name}> is not read: a log's model is made of primitive shapes, with no other file")
        if self._depth > MOST_DEPTH:
            raise self._refusal(f"more than {MOST_DEPTH} elements within each other")
        if self._seen.total() > limit(_LIMIT):
            raise self._refusal(f"more than {limit(_LIMIT):,} elements", limit_hint(_LIMIT, self._most_elements))
        if self._seen["joint"] + self._seen["freejoint"] > MOST_JOINTS:
            raise self._refusal(f"more than {MOST_JOINTS} joints")
        for attribute, value in attributes.items():
            if fault := _fault(name, attribute, value):
                raise self._refusal(f"<{name}> {attribute}={_short(value)}: {fault}")
        self._count_pixels(name, attributes)
        pairs = "".join(f" {attribute}={quoteattr(value)}" for attribute, value in attributes.items())
        self.written.append(f"<{name}{pairs}>")

    def _end(self, name: str) -> None:
        self._depth -= 1
        self.written.append(f"</{name}>")

    def _count_pixels(self, name: str, attributes: Mapping[str, str]) -> None:
        rows, columns = ("nrow", "ncol") if name == "hfield" else ("height", "width")
        if name in ("hfield", "texture"):
            pixels = [abs(int(attributes.get(side, "0").split()[0])) for side in (rows, columns)]
            self._pixels += 6 * max(pixels) ** 2 if name == "texture" else pixels[0] * pixels[1]  # six sides of a cube
        if self._pixels > MOST_PIXELS:
            raise self._refusal(f"textures and height fields of more than {MOST_PIXELS:,} pixels")

    def _refusal(self, problem: str, hint: str | None = None) -> InputError:
        return InputError(problem, where=f"{self._where}:{self.parser.CurrentLineNumber}", hint=hint)


def _fault(element: str, attribute: str, value: str) -> str:
    """Return why an attribute must not be, nothing if it may."""
    if _FILE.fullmatch(attribute):
        return "a log's model names no other file"
    if (element, attribute) in _REFUSED:
        return _REFUSED[element, attribute]
    words = value.split()
    if any(_NO_NUMBER.fullmatch(word) for word in words):
        return "is not a finite number"
    if (element, attribute) == ("size", "memory"):
        match = _MEMORY.fullmatch(value.strip())
        most = MOST_MEMORY
        return "" if match and int(match[1] or 0) * _BYTES[match[2] or ""] <= most else f"at most {size_text(most)}"
    if attribute in COUNTS and (element, attribute) not in _LENGTHS:
        is_within = all(_COUNT.fullmatch(word) and int(word) <= COUNTS[attribute] for word in words)
        return "" if words and is_within else f"a whole number up to {COUNTS[attribute]:,} is expected"
    return "takes a simulation of its own to compile" if attribute in _KINDS and "muscle" in words else ""


def _short(value: str) -> str:
    return repr(value if len(value) <= 40 else f"{value[:40]}...")
