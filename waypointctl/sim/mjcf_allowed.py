"""Which elements and attributes of MJCF are read, and the most that those may count that count something."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Final

from waypointctl.limits import size_text

MOST_MEMORY: Final = 2**26  # [bytes] that the model may ask for to work in

ELEMENTS: Final = frozenset(
    re.findall(
        r"\w+",
        """
        mujoco compiler option flag size statistic visual global quality headlight map scale rgba default asset texture
        material layer hfield mesh include worldbody body inertial joint freejoint geom site camera light frame contact
        pair exclude tendon spatial fixed pulley equality connect weld actuator general motor position velocity
        intvelocity damper cylinder adhesion custom numeric text tuple element keyframe key

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
_FILE: Final = re.compile(r"file\w*|\w+dir|plugin|content_type|strippath")  # names a file, or where it is
FOLDERS: Final = ("assetdir", "meshdir", "texturedir", "strippath")  # of <compiler>
_ASSETS: Final = {"mesh": (".stl", ".obj"), "texture": (".png",)}  # elements that may name a file, and its kinds
_REFUSED: Final = {  # and why
    ("rangefinder", "camera"): "is not read: it casts a ray for each pixel",
    ("mesh", "builtin"): "is not read: give the mesh as a file or its vertices",
    **{("size", name): "is not read; use 'memory' instead" for name in ("njmax", "nconmax", "nstack")},
}
_COUNT: Final = re.compile(r"-1|[0-9]{1,9}")
_KINDS: Final = ("dyntype", "gaintype", "biastype")
_MEMORY: Final = re.compile(r"-1|([0-9]{1,9})([KMG]?)")
_BYTES: Final = {"": 1, "K": 2**10, "M": 2**20, "G": 2**30}
_NO_NUMBER: Final = re.compile(r"[+-]?(nan(\(.*\))?|inf(inity)?)", re.IGNORECASE)


def attribute_fault(element: str, attribute: str, value: str) -> str:
    """Return why an attribute must not be, nothing if it may."""
    if _FILE.fullmatch(attribute):
        return _file_fault(element, attribute, value)
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


def _file_fault(element: str, attribute: str, value: str) -> str:
    """Return why an attribute must not name a file, nothing if it may."""
    if element == "compiler" and attribute in FOLDERS:
        return ""
    if attribute == "file" and element in _ASSETS:
        kinds = _ASSETS[element]
        return "" if value.lower().endswith(kinds) else f"is not read; a {element} is a file {' or '.join(kinds)}"
    return "is not read: a robot's model names meshes and PNG textures alone"
