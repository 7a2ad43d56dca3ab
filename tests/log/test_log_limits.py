"""What a log takes is counted before it is taken, and each limit can be changed."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lz4.frame
import pytest
import zstandard
from mcap import records as mcap
from mcap.opcode import Opcode

from tests.log.forging import Chunk, Forgery
from waypointctl.errors import LogError
from waypointctl.limits import LIMITS, VARIABLE
from waypointctl.log.reader import open_log
from waypointctl.log.records import Record

MIB = 2**20
PRIVATE = 0x80


@pytest.fixture
def refused(log_path: Path, tmp_path: Path) -> Callable[[Callable[[Forgery], None]], str]:
    """Open the log after a change to it, and return why that is refused."""

    def why(change: Callable[[Forgery], None]) -> str:
        forgery = Forgery.of(log_path.read_bytes())
        change(forgery)
        path = tmp_path / "forged.mcap"
        path.write_bytes(forgery.file())
        with pytest.raises(LogError) as caught:
            open_log(path)
        return str(caught.value)

    return why


def of_zeros(size: int, compression: str = "zstd", **lies: Any) -> Chunk:
    """Return a chunk that unpacks to `size` bytes: one unknown record of zeros."""
    record = Record(0, PRIVATE, bytes(size - 9)).raw
    data = {"zstd": zstandard.compress, "lz4": lz4.frame.compress, "": bytes}[compression](record)
    return Chunk([], compression, {"data": data, "uncompressed_size": size, "uncompressed_crc": 0, **lies})


@pytest.mark.parametrize("compression", ["zstd", "lz4", ""])
def test_a_chunk_of_more_than_is_read_is_not_unpacked(
    refused: Callable[[Callable[[Forgery], None]], str], compression: str
) -> None:
    said = refused(lambda forgery: forgery.data.append(of_zeros(33 * MIB, compression)))
    assert "has at least 34,603,008 bytes in one chunk; the limit log-chunk is 32 MiB\n" in said
    assert said.endswith("raise the limit: `waypointctl --limit log-chunk=64MiB COMMAND ...`")


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
@pytest.mark.parametrize("declared", [0, 1, 99, 33 * MIB - 1])
def test_a_chunk_that_unpacks_to_more_than_it_says_is_not_unpacked_further(
    refused: Callable[[Callable[[Forgery], None]], str],
    monkeypatch: pytest.MonkeyPatch,
    compression: str,
    declared: int,
) -> None:
    monkeypatch.setenv(VARIABLE, f"log-chunk={40 * MIB}")
    chunk = of_zeros(33 * MIB, compression, uncompressed_size=declared)
    said = refused(lambda forgery: forgery.data.append(chunk))
    assert "is damaged at byte" in said


@pytest.mark.parametrize("declared", [0, 99, 2 * MIB])
def test_one_whose_compression_does_not_say_how_much_it_is(
    refused: Callable[[Callable[[Forgery], None]], str], declared: int
) -> None:
    packer = zstandard.ZstdCompressor(write_content_size=False).compressobj()
    data = packer.compress(bytes(MIB)) + packer.flush()
    chunk = of_zeros(MIB, data=data, uncompressed_size=declared)
    assert "is damaged at byte" in refused(lambda forgery: forgery.data.append(chunk))


def test_bytes_behind_the_compressed_ones_are_damage(refused: Callable[[Callable[[Forgery], None]], str]) -> None:
    for compression, pack in (("zstd", zstandard.compress), ("lz4", lz4.frame.compress)):
        chunk = of_zeros(900, compression, data=pack(bytes(900)) + pack(b"hidden"))
        assert "is damaged at byte" in refused(lambda forgery, chunk=chunk: forgery.data.append(chunk))  # type: ignore[misc]


def test_many_chunks_are_bounded_by_the_size_of_the_file(refused: Callable[[Callable[[Forgery], None]], str]) -> None:
    chunk = of_zeros(30 * MIB)
    said = refused(lambda forgery: forgery.data.extend([chunk] * 9))
    assert "times as many bytes in chunks as in the file; the limit log-expansion is 100\n" in said


@pytest.mark.parametrize(("opcode", "body"), [(Opcode.MESSAGE, b"\1" + bytes(21)), (PRIVATE, b"")])
def test_messages_are_bounded_by_the_size_of_the_file(
    refused: Callable[[Callable[[Forgery], None]], str], opcode: int, body: bytes
) -> None:
    def many(forgery: Forgery) -> None:
        data = 150_000 * Record(0, opcode, body).raw
        lies = {"data": zstandard.compress(data), "uncompressed_size": len(data), "uncompressed_crc": 0}
        forgery.data.append(Chunk([], "zstd", lies))

    assert "messages more than its file has room for an index of; the limit log-messages is 100,000" in refused(many)


def test_metadata_of_many_entries(refused: Callable[[Callable[[Forgery], None]], str]) -> None:
    said = refused(lambda forgery: forgery.metadata().update({str(i): "" for i in range(200_000)}))
    assert "has at least 200,004 entries" in said
    assert "the limit log-entries is 1,000" in said
    assert int(said.partition("--limit log-entries=")[2].split()[0]) > 200_004, "one hint is enough"


@pytest.mark.parametrize(
    "change",
    [
        lambda forgery: forgery.data.insert(0, Record(0, PRIVATE, bytes(90_000)).raw),
        lambda forgery: forgery.data.insert(0, mcap.Attachment(0, 0, "large", "", bytes(90_000))),
    ],
    ids=["private", "attachment"],
)
def test_a_record_of_any_kind_is_bounded(
    refused: Callable[[Callable[[Forgery], None]], str],
    monkeypatch: pytest.MonkeyPatch,
    change: Callable[[Forgery], None],
) -> None:
    monkeypatch.setenv(VARIABLE, "log-record=80000")
    assert "the limit log-record is 80000 B" in refused(change)


@pytest.mark.parametrize("name", [name for name in LIMITS if name.startswith("log-")])
def test_each_limit_can_be_set(log_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    enough = {name: each.default for name, each in LIMITS.items()}
    monkeypatch.setenv(VARIABLE, f"{name}={enough[name]}")
    assert open_log(log_path).message_count > 0
    if name not in ("log-expansion", "log-messages"):  # of which a log that is written here never has any
        monkeypatch.setenv(VARIABLE, f"{name}=1")
        with pytest.raises(LogError, match=f"the limit {name} is "):
            open_log(log_path)


@pytest.mark.parametrize("compression", ["", "lz4", "zstd"])
def test_what_other_tools_have_packed_is_read(log_path: Path, tmp_path: Path, compression: str) -> None:
    forgery = Forgery.of(log_path.read_bytes())
    for chunk in forgery.chunks:
        chunk.compression = compression
    path = tmp_path / "packed.mcap"
    path.write_bytes(forgery.file())
    assert [*open_log(path).raw_messages()] == [*open_log(log_path).raw_messages()]


def test_a_compression_that_nobody_knows_is_damage(refused: Callable[[Callable[[Forgery], None]], str]) -> None:
    def change(forgery: Forgery) -> None:
        forgery.chunks[1].lies = {"compression": "brotli"}

    assert "is compressed with 'brotli'; allowed are zstd, lz4, and nothing" in refused(change)


def test_a_pipe_is_no_log(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "log.mcap")
    with pytest.raises(LogError, match="is a named pipe, not a file"):
        open_log(tmp_path / "log.mcap")
