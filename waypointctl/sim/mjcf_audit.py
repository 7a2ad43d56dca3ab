"""Auditing untrusted MJCF before MuJoCo reads it: what is allowed, and how large it makes the model.

MuJoCo reads files that MJCF names (include, meshes, textures, height fields, plugins), and takes the memory that its
numbers request before it checks them. Elements are therefore an allow-list, counts have limits, and the only files
are meshes, PNG textures and included MJCF of the robot's own folder. MuJoCo's parser is not this one: it is given the
elements and attributes that were read here, written anew, and the files by names of ours, never the text.
Elements and attributes: https://mujoco.readthedocs.io/en/stable/XMLreference.html.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Final, TypeAlias
from xml.parsers import expat

from waypointctl.errors import InputError
from waypointctl.limits import limit, limit_hint, over_limit
from waypointctl.sim.mjcf_allowed import ELEMENTS, FOLDERS, attribute_fault

ReadFile: TypeAlias = Callable[[str], bytes]  # of the robot's folder, by its path in there; may raise InputError

MOST_BYTES: Final = 2**20
MOST_DEPTH: Final = 64
MOST_FILES: Final = 200
MOST_JOINTS: Final = 128
MOST_PIXELS: Final = 2**24  # of all textures and height fields together

# As xml.sax.saxutils.quoteattr, which loads an HTTP client.
_ENTITIES: Final = str.maketrans(
    {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
)
_LIMIT: Final = "model-elements"
_FILES_LIMIT: Final = "robot-files"

_PNG: Final = b"\x89PNG\r\n\x1a\n"


@dataclass(frozen=True, slots=True)
class AuditedMjcf:
    """MJCF that may be compiled."""

    xml: str  # the elements and attributes that were read, in one text
    assets: Mapping[str, bytes]  # meshes and textures, by the names that `xml` has for them
    # All that was read, by path in the robot's folder: the MJCF, what it includes, meshes, textures
    files: Mapping[str, bytes]


def audited_mjcf(path: str, read: ReadFile, where: str = "") -> AuditedMjcf:
    """Return MJCF with the content that an XML parser reads from a file, after everything in it has been checked.

    Args:
        path: of the MJCF in the robot's folder.
        read: returns a file of the folder.
        where: the folder, for messages; it ends in "/".

    Raises:
        InputError: it is not MJCF, it names a file outside the folder or of another kind, it has what is not read here,
            or it is over a limit.
    """
    audit = _Audit(read, where)
    audit.parse(path)
    assets = audit.assets()
    return AuditedMjcf("".join(audit.written), assets, audit.files)


@dataclass(frozen=True, slots=True)
class _AssetFile:
    """An element that names a file: its position among those that are written, and in the source."""

    at: int
    element: str
    attributes: Mapping[str, str]
    where: str


class _Audit:
    """Takes elements as they come, refuses what must not be, and writes down the others."""

    def __init__(self, read: ReadFile, folder: str) -> None:
        self.written: list[str] = []
        self.files: dict[str, bytes] = {}
        self._read = read
        self._folder = folder
        self._path = ""  # of the file that is being parsed
        self._parser = expat.ParserCreate("UTF-8")
        self._is_written: list[bool] = []  # of each element that is open
        self._root_depth = 1
        self._most_elements = 0
        self._seen: Counter[str] = Counter()
        self._pixels = 0
        self._folders: dict[str, str] = {}  # of <compiler>
        self._asset_files: list[_AssetFile] = []

    def parse(self, path: str) -> None:
        """Read the elements of a file."""
        source = self._file(path, self._folder + path)
        where = self._folder + path
        if len(source) > MOST_BYTES:
            raise InputError(f"has {len(source):,} bytes; {MOST_BYTES:,} are read", where=where)
        try:
            source.decode()
        except UnicodeDecodeError as error:
            raise InputError(f"is not UTF-8 text: byte {error.start}", where=where) from error
        outer = self._path, self._parser, self._root_depth
        self._path, self._parser, self._root_depth = path, expat.ParserCreate("UTF-8"), len(self._is_written) + 1
        self._parser.StartDoctypeDeclHandler = self._doctype  # whatever encoding it declares, it is UTF-8 to MuJoCo
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._most_elements += source.count(b"<")
        try:
            self._parser.Parse(source, True)
        except expat.ExpatError as error:
            raise InputError(f"is not XML: {error}", where=where) from error
        self._path, self._parser, self._root_depth = outer

    def assets(self) -> dict[str, bytes]:
        """Return the files of meshes and textures by their new names, which are now in what is written."""
        found: dict[str, bytes] = {}
        for asset in self._asset_files:
            attributes = dict(asset.attributes)
            path = PurePosixPath(attributes["file"])
            if self._folders.get("strippath") == "true":
                path = PurePosixPath(path.name)
            folder = self._folders.get(f"{asset.element}dir", self._folders.get("assetdir", ""))
            content = self._file(_inside(PurePosixPath(folder) / path, asset.where), asset.where)
            if asset.element == "texture":
                self._count(_png_pixels(content, asset.where), asset.where)
            suffix = path.suffix.lower()
            new = f"{len(found)}{suffix}"  # MuJoCo looks for it among the assets alone, by its name without folders
            found[new] = content
            attributes |= {"name": attributes.get("name", path.stem), "file": new}
            self.written[asset.at] = _tag(asset.element, attributes)
        return found

    def _doctype(self, *_: object) -> None:
        raise self._refusal("a document type, which can define entities, is not read")

    def _start(self, name: str, attributes: Mapping[str, str]) -> None:
        is_root = len(self._is_written) + 1 == self._root_depth
        is_main = self._root_depth == 1
        self._is_written.append(name != "include" and (is_main or not is_root))
        if is_root:
            if name != "mujoco" and (is_main or name != "mujocoinclude"):
                kind = "a URDF" if name == "robot" else "not MJCF"
                raise self._refusal(f"is {kind}: its root is <{name}>, that of MJCF is <mujoco>")
            if not is_main:
                return
        self._check_counts(name)
        if name == "include":
            self._include(attributes)
            return
        for attribute, value in attributes.items():
            if fault := attribute_fault(name, attribute, value):
                raise self._refusal(f"<{name}> {attribute}={_short(value)}: {fault}")
        if name == "compiler":
            self._folders |= {key: attributes[key] for key in FOLDERS if key in attributes}
            attributes = {key: value for key, value in attributes.items() if key not in FOLDERS}
        if "file" in attributes:
            self._asset_files.append(_AssetFile(len(self.written), name, attributes, self._where))
        self._count_pixels(name, attributes)
        self.written.append(_tag(name, attributes))

    def _end(self, name: str) -> None:
        if self._is_written.pop():
            self.written.append(f"</{name}>")

    def _check_counts(self, name: str) -> None:
        self._seen[name] += 1
        if name not in ELEMENTS:
            raise self._refusal(f"<{name}> is not read: a robot's model has rigid bodies, primitive shapes and meshes")
        if len(self._is_written) > MOST_DEPTH:
            raise self._refusal(f"more than {MOST_DEPTH} elements within each other")
        if self._seen.total() > limit(_LIMIT):
            raise self._refusal(f"more than {limit(_LIMIT):,} elements", limit_hint(_LIMIT, self._most_elements))
        if self._seen["joint"] + self._seen["freejoint"] > MOST_JOINTS:
            raise self._refusal(f"more than {MOST_JOINTS} joints")

    def _include(self, attributes: Mapping[str, str]) -> None:
        if set(attributes) != {"file"}:
            raise self._refusal("<include> has a 'file' and nothing else")
        path = _inside(PurePosixPath(attributes["file"]), self._where)
        if path in self.files:
            raise self._refusal(f"<include> file={_short(path)}: is included already")
        self.parse(path)

    def _file(self, path: str, where: str) -> bytes:
        """Return a file of the folder; the limits are those of all of them together."""
        if path not in self.files:
            if len(self.files) == MOST_FILES:
                raise InputError(f"names more than {MOST_FILES} files", where=where)
            try:
                self.files[path] = self._read(path)
            except InputError as error:
                if where == self._folder + path:
                    raise
                raise InputError(f"names the file {path!r}: {error.problem}", where=where, hint=error.hint) from error
            if (size := sum(len(content) for content in self.files.values())) > limit(_FILES_LIMIT):
                raise InputError(over_limit(_FILES_LIMIT, size), where=where, hint=limit_hint(_FILES_LIMIT))
        return self.files[path]

    def _count_pixels(self, name: str, attributes: Mapping[str, str]) -> None:
        rows, columns = ("nrow", "ncol") if name == "hfield" else ("height", "width")
        if name in ("hfield", "texture"):
            pixels = [abs(int(attributes.get(side, "0").split()[0])) for side in (rows, columns)]
            self._count(6 * max(pixels) ** 2 if name == "texture" else pixels[0] * pixels[1], self._where)  # of a cube

    def _count(self, pixels: int, where: str) -> None:
        self._pixels += pixels
        if self._pixels > MOST_PIXELS:
            raise InputError(f"textures and height fields of more than {MOST_PIXELS:,} pixels", where=where)

    @property
    def _where(self) -> str:
        return f"{self._folder}{self._path}:{self._parser.CurrentLineNumber}"

    def _refusal(self, problem: str, hint: str | None = None) -> InputError:
        return InputError(problem, where=self._where, hint=hint)


def _tag(name: str, attributes: Mapping[str, str]) -> str:
    pairs = "".join(f' {attribute}="{value.translate(_ENTITIES)}"' for attribute, value in attributes.items())
    return f"<{name}{pairs}>"


def _inside(path: PurePosixPath, where: str) -> str:
    """Return the path of a file in the robot's folder.

    Raises:
        InputError: it leads out of the folder.
    """
    if path.is_absolute() or ".." in path.parts or "\\" in str(path) or "\0" in str(path):
        raise InputError(f"names the file {_short(str(path))}, which is not in the robot's folder", where=where)
    return str(path)


def _png_pixels(content: bytes, where: str) -> int:
    """Return the number of pixels that a PNG declares."""
    if not content.startswith(_PNG) or content[12:16] != b"IHDR":
        raise InputError("names a texture that is not a PNG", where=where)
    return int.from_bytes(content[16:20]) * int.from_bytes(content[20:24])


def _short(value: str) -> str:
    return repr(value if len(value) <= 40 else f"{value[:40]}...")
