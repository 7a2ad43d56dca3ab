"""No byte of a log can change, and no byte can be missing, without being noticed."""

from __future__ import annotations

import random
import zlib
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

import pytest
import zstandard
from mcap.opcode import Opcode
from mcap.records import Chunk
from mcap.writer import Writer

from tests.log.fake_flight import bits, flight
from waypointctl.errors import LogError
from waypointctl.log.chunk import encoded
from waypointctl.log.opening import MAGIC
from waypointctl.log.reader import open_log
from waypointctl.log.records import Record, body_stream, records


def some_offsets(size: int, count: int) -> list[int]:
    return sorted(random.Random(3).sample(range(size), count))


def test_any_flipped_bit_is_found(log_path: Path, tmp_path: Path) -> None:
    whole = log_path.read_bytes()
    path = tmp_path / "damaged.mcap"
    # Everywhere in general, and every byte of the last, where the index and the footer stand.
    for offset in [*some_offsets(len(whole), 100), *range(len(whole) - 60, len(whole))]:
        changed = bytearray(whole)
        changed[offset] ^= 1 << offset % 8
        path.write_bytes(changed)
        with pytest.raises(LogError, match=r"damaged\.mcap: "):
            open_log(path)


def test_any_cut_is_found_and_what_came_before_is_read(log_path: Path, tmp_path: Path) -> None:
    whole = log_path.read_bytes()
    written = [bits(message) for message in flight()]
    path = tmp_path / "cut.mcap"
    counts = []
    with open(log_path, "rb") as stream:
        metadata_end = next(it.offset for it in records(stream, 8, len(whole)) if it.opcode == Opcode.CHUNK)
    for size in [*some_offsets(len(whole), 40), len(whole) - 1]:
        path.write_bytes(whole[:size])
        with pytest.raises(LogError, match="is cut short"):
            open_log(path)
        if size < metadata_end:
            with pytest.raises(LogError, match="is cut short before its metadata"):
                open_log(path, allow_truncated=True)
            continue
        log = open_log(path, allow_truncated=True)
        read = [bits(message) for message in log.messages()]
        assert not log.is_complete
        assert read == written[: len(read)]
        counts.append(len(read))
    assert counts == sorted(counts)
    assert counts[-1] == len(written)


def test_damage_in_a_chunk_names_its_byte(log_path: Path, tmp_path: Path) -> None:
    whole = bytearray(log_path.read_bytes())
    with open(log_path, "rb") as stream:
        chunk = [record for record in records(stream, 8, len(whole)) if record.opcode == Opcode.CHUNK][2]
    whole[chunk.offset + len(chunk.body) // 2] ^= 1
    path = tmp_path / "damaged.mcap"
    path.write_bytes(whole)
    with pytest.raises(LogError, match=rf"is damaged at byte {chunk.offset}: .*\n  The file is not as it was written"):
        open_log(path)
    with pytest.raises(LogError, match="is damaged at byte"):
        open_log(path, allow_truncated=True)


def test_damage_in_an_attachment_is_a_wrong_checksum(log_path: Path, tmp_path: Path) -> None:
    whole = log_path.read_bytes()
    path = tmp_path / "damaged.mcap"
    path.write_bytes(whole.replace(b"name: fake", b"name: fame"))
    with pytest.raises(LogError, match="the checksum is 0x"):
        open_log(path)


def rebuilt(whole: bytes, change: Callable[[Chunk], None]) -> bytes:
    """Return a log after `change` to its second chunk, no checksum of the file as a whole telling of it."""
    parts = [MAGIC]
    seen = 0
    for record in records(BytesIO(whole), len(MAGIC), len(whole)):
        body = record.body
        if record.opcode == Opcode.CHUNK:
            seen += 1
            if seen == 2:
                chunk = Chunk.read(body_stream(body))
                change(chunk)
                body = encoded(chunk)[9:]
        elif record.opcode == Opcode.DATA_END:
            body = bytes(4)
        elif record.opcode == Opcode.FOOTER:
            body = body[:-4] + bytes(4)
        parts.append(Record(record.offset, record.opcode, body).raw)
    return b"".join([*parts, MAGIC])


def is_read(path: Path) -> bool:
    """Tell whether a log is read to its end, or refused; anything but a LogError passes through."""
    try:
        list(open_log(path).messages())
    except LogError:
        return False
    return True


def test_a_chunk_that_says_it_is_larger_than_any_memory(log_path: Path, tmp_path: Path) -> None:
    def enlarge(chunk: Chunk) -> None:
        chunk.uncompressed_size = 2**64 - 1

    path = tmp_path / "large.mcap"
    path.write_bytes(rebuilt(log_path.read_bytes(), enlarge))
    with pytest.raises(LogError, match="the limit log-chunk is 32 MiB"):
        open_log(path)


@pytest.mark.parametrize(("compression", "good"), [("", True), ("lz4", False)])
def test_a_chunk_that_says_another_compression(log_path: Path, tmp_path: Path, compression: str, good: bool) -> None:
    def relabel(chunk: Chunk) -> None:
        chunk.data = zstandard.decompress(chunk.data, chunk.uncompressed_size)
        chunk.compression = compression

    path = tmp_path / "other.mcap"
    path.write_bytes(rebuilt(log_path.read_bytes(), relabel))
    assert is_read(path) is good


def test_a_chunk_whose_checksum_alone_is_wrong_is_refused(log_path: Path, tmp_path: Path) -> None:
    def lie(chunk: Chunk) -> None:
        chunk.uncompressed_crc ^= 1

    path = tmp_path / "damaged.mcap"
    path.write_bytes(rebuilt(log_path.read_bytes(), lie))
    assert not is_read(path)


def test_damage_that_every_checksum_agrees_with_is_refused_or_read(log_path: Path, tmp_path: Path) -> None:
    whole = log_path.read_bytes()
    path = tmp_path / "damaged.mcap"
    rng = random.Random(5)

    def corrupt(chunk: Chunk) -> None:
        data = bytearray(zstandard.decompress(chunk.data, chunk.uncompressed_size))
        for _ in range(3):
            data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        chunk.data, chunk.uncompressed_crc = zstandard.compress(bytes(data)), zlib.crc32(data)

    found = set()
    for _ in range(60):
        path.write_bytes(rebuilt(whole, corrupt))
        found.add(is_read(path))
    assert found == {True, False}  # a changed number is a number


def test_missing_log(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"none\.mcap: no such log"):
        open_log(tmp_path / "none.mcap")


def test_folder(tmp_path: Path) -> None:
    with pytest.raises(LogError, match=r"is a folder; a log is one \.mcap file"):
        open_log(tmp_path)


@pytest.mark.parametrize("allow_truncated", [False, True])
def test_empty_file(tmp_path: Path, allow_truncated: bool) -> None:
    path = tmp_path / "empty.mcap"
    path.touch()
    with pytest.raises(LogError, match=r"empty\.mcap: is empty"):
        open_log(path, allow_truncated=allow_truncated)


@pytest.mark.parametrize("data", [b"x", b"name: mission\n", b"\x89MCAP1\r\n" + bytes(50)])
def test_not_mcap(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "mission.yaml"
    path.write_bytes(data)
    with pytest.raises(LogError, match=r"mission\.yaml: is not an MCAP file"):
        open_log(path, allow_truncated=True)


def write_mcap(path: Path, metadata: dict[str, str] | None) -> None:
    with open(path, "wb") as stream:
        writer = Writer(stream)
        writer.start()
        if metadata is not None:
            writer.add_metadata("waypointctl", metadata)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated


@pytest.mark.parametrize(
    ("metadata", "message"),
    [
        (None, "is an MCAP file, but not a log of waypointctl"),
        ({"schema_version": "1"}, "has the schema version 1; this waypointctl reads 2\n.*older"),
        ({"schema_version": "3"}, "has the schema version 3; this waypointctl reads 2\n.*newer"),
        ({"schema_version": "9" * 5000}, r"has the schema version '9{20}\.\.\.' in its metadata; a whole number"),
        ({"schema_version": "\u0661"}, "a whole number is expected"),
        ({}, "has the schema version '' in its metadata; a whole number is expected"),
    ],
)
def test_logs_of_others(tmp_path: Path, metadata: dict[str, str] | None, message: str) -> None:
    path = tmp_path / "other.mcap"
    write_mcap(path, metadata)
    with pytest.raises(LogError, match=message):
        open_log(path)


def test_records_are_all_there_is(log_path: Path) -> None:
    size = log_path.stat().st_size
    with open(log_path, "rb") as stream:
        found = list(records(stream, 8, size))
    raw = b"".join(record.raw for record in found)
    assert raw == log_path.read_bytes()[8:-8]
