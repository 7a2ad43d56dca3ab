"""Reading parts of an untrusted .zip: whatever it declares, no more is unpacked than the caller allows."""

from __future__ import annotations

import io
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from waypointctl.mission.file_kind import FileKind, is_lfs_pointer

MOST_PARTS: Final = 10_000

_ENTRY: Final = b"PK\x01\x02"  # what the central directory has before each part
# What the standard library raises for a .zip with bytes that are not those that were written.
_DAMAGE: Final = (zipfile.BadZipFile, zipfile.LargeZipFile, zlib.error, NotImplementedError, RuntimeError, OSError,
                  EOFError, OverflowError)  # fmt: skip


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
