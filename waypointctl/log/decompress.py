"""A chunk's records out of their compression: never more of them than the chunk says, and it must not say too much."""

from __future__ import annotations

import zlib
from typing import Final

import zstandard
from mcap.records import Chunk

from waypointctl.limits import limit
from waypointctl.log.bounds import OverLimit
from waypointctl.log.records import Record, body_stream

_UNSAID: Final = -1  # by zstd's frame: how much it unpacks to


def chunk_bytes(record: Record) -> bytes:
    """Return the uncompressed records of a chunk, its size and checksum checked.

    Raises:
        OverLimit: it unpacks to more than is read.
        one of DAMAGE: it is not what was written.
    """
    chunk = Chunk.read(body_stream(record.body))
    if chunk.uncompressed_size > limit("log-chunk"):
        raise OverLimit("log-chunk", "bytes in one chunk", chunk.uncompressed_size)
    data = _decompressed(chunk)
    if len(data) != chunk.uncompressed_size:
        raise ValueError(f"a chunk unpacks to {len(data)} bytes; it says {chunk.uncompressed_size}")
    crc = zlib.crc32(data)
    if chunk.uncompressed_crc not in (0, crc):
        raise ValueError(f"the checksum of a chunk is {crc:#010x}, written was {chunk.uncompressed_crc:#010x}")
    return data


def _decompressed(chunk: Chunk) -> bytes:
    match chunk.compression:
        case "zstd":
            return _zstd(chunk.data, chunk.uncompressed_size)
        case "lz4":
            return _lz4(chunk.data, chunk.uncompressed_size)
        case "":
            return chunk.data
        case other:
            raise ValueError(f"a chunk is compressed with {other[:20]!r}; allowed are zstd, lz4, and nothing")


def _zstd(data: bytes, size: int) -> bytes:
    said = zstandard.frame_content_size(data)
    if said not in (size, _UNSAID):  # as much memory is taken as the frame says
        raise ValueError(f"zstd says {said} bytes, the chunk {size}")
    return zstandard.ZstdDecompressor().decompress(data, max_output_size=max(size, 1), allow_extra_data=False)


def _lz4(data: bytes, size: int) -> bytes:
    import lz4.frame  # peers write it, waypointctl does not

    decompressor = lz4.frame.LZ4FrameDecompressor()
    try:
        unpacked: bytes = decompressor.decompress(data, max_length=size + 1)
    except RuntimeError as error:
        raise ValueError(str(error)) from error
    if decompressor.unused_data or not decompressor.eof:
        raise ValueError("a chunk has more or less lz4 data than it says")
    return unpacked
