"""The tensors of a file that torch.save() wrote, as numpy arrays. Neither torch nor the pickle in it runs.

Such a file is a .zip: data.pkl, a pickle with the storage of each tensor, and data/0, data/1, ... with the numbers
(torch/serialization.py, torch/_utils.py). Whatever a .zip declares, no more is unpacked than the caller allows.
"""

from __future__ import annotations

import io
import math
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from waypointctl.importers.stable_baselines3.inert_pickle import Inert, origin_of, read_inert
from waypointctl.mission.file_kind import FileKind, is_lfs_pointer

MOST_PARTS: Final = 10_000

_ENTRY: Final = b"PK\x01\x02"  # what the central directory has before each part
# What the standard library raises for a .zip with bytes that are not those that were written.
_DAMAGE: Final = (zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, NotImplementedError, RuntimeError, OSError,
                  EOFError, OverflowError)  # fmt: skip

Array: TypeAlias = NDArray[np.floating]
MOST_TENSORS: Final = 1000
_KINDS: Final = {"torch.FloatStorage": "f4", "torch.DoubleStorage": "f8", "torch.HalfStorage": "f2"}
_TENSOR: Final = "torch._utils._rebuild_tensor_v2"
_PARAMETER: Final = "torch._utils._rebuild_parameter"
_MOST_DIMENSIONS: Final = 8
_PICKLE: Final = "data.pkl"


@contextmanager
def opened_zip(content: bytes) -> Iterator[zipfile.ZipFile]:
    """Yield a .zip for reading; what its damage raises while it is read becomes a ValueError.

    Raises:
        ValueError: it is none, is damaged, or has more than `MOST_PARTS`.
    """
    if is_lfs_pointer(content):
        raise ValueError(FileKind.LFS_POINTER.value)
    if content.count(_ENTRY) > MOST_PARTS:  # each would take half a kilobyte of memory
        raise ValueError(f"not a .zip that is read: it has more than {MOST_PARTS:,} parts")
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            yield archive
    except _DAMAGE as error:
        raise ValueError(f"not a .zip that can be read: {error}") from error


def read_part(archive: zipfile.ZipFile, name: str, most: int) -> bytes:
    """Return what a part unpacks to.

    Raises:
        ValueError: it is not there, or has more than `most` bytes.
    """
    if name not in archive.namelist():
        raise ValueError(f"no {name} in it")
    # The size that the .zip declares is only a claim.
    with archive.open(name) as part:
        content = part.read(most + 1)
    if len(content) > most:
        raise ValueError(f"{name} unpacks to more than the {most:,} bytes that are read")
    return content


def read_tensors(content: bytes, most: int) -> dict[str, Array]:
    """Return the tensors of a state dict, by name.

    Args:
        content: the file's bytes.
        most: bytes that all of them together may have.

    Raises:
        ValueError: it is something else, or a tensor is not of finite float16, float32 or float64 numbers.
    """
    with opened_zip(content) as archive:
        names = archive.namelist()
        pickled = next((name for name in names if name.endswith(f"/{_PICKLE}")), None)
        if pickled is None:
            raise ValueError("it is not a file of torch.save()")
        folder = pickled.removesuffix(_PICKLE)
        saved = read_inert(read_part(archive, pickled, most))
        if not isinstance(saved, dict) or not all(isinstance(name, str) for name in saved):
            raise ValueError(f"it is not tensors by name but {_shown(saved)}")
        if len(saved) > MOST_TENSORS:
            raise ValueError(f"it has {len(saved)} tensors; {MOST_TENSORS} are read")
        order = f"{folder}byteorder"
        is_big = order in names and read_part(archive, order, 10) == b"big"
        arrays: dict[str, Array] = {}
        for name, described in saved.items():
            left = most - sum(array.nbytes for array in arrays.values())
            try:
                arrays[name] = _layout(described, ">" if is_big else "<").read(archive, folder, left)
            except ValueError as error:
                raise ValueError(f"{name} {error}") from error
        return arrays


@dataclass(frozen=True, slots=True)
class _Layout:
    """Where a tensor's numbers are: element (i, j, ...) is number offset + i * strides[0] + j * strides[1] + ..."""

    part: str
    dtype: np.dtype[Any]
    offset: int
    shape: tuple[int, ...]
    strides: tuple[int, ...]

    def __post_init__(self) -> None:
        counts = (self.offset, *self.shape, *self.strides)
        if not all(type(count) is int and count >= 0 for count in counts) or len(self.shape) != len(self.strides):
            raise ValueError("has a shape that cannot be")
        if len(self.shape) > _MOST_DIMENSIONS:
            raise ValueError(f"has {len(self.shape)} dimensions; at most {_MOST_DIMENSIONS} are read")

    def read(self, archive: zipfile.ZipFile, folder: str, most: int) -> Array:
        size = math.prod(self.shape)
        if size * self.dtype.itemsize > most:
            raise ValueError(f"makes the tensors larger than what is read, by its shape {self.shape}")
        content = read_part(archive, f"{folder}data/{self.part}", most)
        numbers = np.frombuffer(content, self.dtype, len(content) // self.dtype.itemsize)
        last = self.offset + sum((n - 1) * stride for n, stride in zip(self.shape, self.strides, strict=True))
        if size and last >= numbers.size:
            raise ValueError(f"has the shape {self.shape}, which its {numbers.size} numbers do not fill")
        steps = [stride * self.dtype.itemsize for stride in self.strides]
        view = np.lib.stride_tricks.as_strided(numbers[self.offset :], self.shape, steps if size else None)
        array = np.array(view, self.dtype.newbyteorder("="), order="C")
        if not np.all(np.abs(array) <= np.finfo(np.float32).max):  # what the network computes in
            raise ValueError("is not an array of finite numbers")
        return array


def _layout(described: object, order: str) -> _Layout:
    if isinstance(described, Inert) and described.origin == _PARAMETER and described.args:
        described = described.args[0]
    match described:
        case Inert(args=(Inert(args=("storage", kind, str(part), *_)), int(offset), tuple(shape), tuple(strides), *_)):
            if described.origin == _TENSOR and origin_of(kind) in _KINDS:
                return _Layout(part, np.dtype(order + _KINDS[origin_of(kind)]), offset, shape, strides)
            raise ValueError(f"is not an array of finite numbers of 16, 32 or 64 bits but of {_shown(kind)}")
    raise ValueError(f"is not an array of finite numbers but {_shown(described)}")


def _shown(value: object) -> str:
    return ascii(origin_of(value) or type(value).__name__)[:80]
