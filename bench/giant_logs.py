"""What a small log costs that says it is, or unpacks to, gigabytes.

Run: python bench/giant_logs.py

Each log is read by `info`, `replay --verify`, `replay` and `run --resume`, each a process of its own. Printed are the
exit code, the CPU time and the largest memory of the process, and the first line that it says. A fault is an exit code
other than 0, 1 and 2, a traceback, more than 10 s, or more than 1 GiB.
"""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

import lz4.frame
import zstandard
from mcap import records as mcap
from mcap.opcode import Opcode

from tests.log.attacks import PRIVATE
from tests.log.fake_flight import flight, header
from tests.log.forging import Chunk, Forgery
from waypointctl.log.proto import messages_pb2 as pb
from waypointctl.log.records import Record
from waypointctl.log.writer import LogWriter

GIB: Final = 2**30
MIB: Final = 2**20
MOST_CPU_S: Final = 10.0
MOST_BYTES: Final = GIB
COMMANDS: Final = (("info",), ("replay", "--verify"), ("replay",), ("run", "--resume"))


def zstd_zeros(size: int, said: int | None = None) -> bytes:
    """Return a zstd frame of `size` zeros, a multiple of 128 KiB, that says it has `said`: a block is four bytes."""
    block = 2**17
    head = (0xFD2FB528).to_bytes(4, "little") + bytes([0b11000000, 7 << 3]) + (said or size).to_bytes(8, "little")
    blocks = [(block << 3 | 1 << 1).to_bytes(3, "little") + b"\0"] * (size // block)
    blocks[-1] = (block << 3 | 1 << 1 | 1).to_bytes(3, "little") + b"\0"
    return head + b"".join(blocks)


def lz4_zeros(size: int) -> bytes:
    """Return an lz4 frame of `size` zeros."""
    packer = lz4.frame.LZ4FrameCompressor(block_size=lz4.frame.BLOCKSIZE_MAX4MB)
    zeros = bytes(4 * MIB)
    parts: list[bytes] = [packer.begin(), *(packer.compress(zeros) for _ in range(size // len(zeros))), packer.flush()]
    return b"".join(parts)


def chunk(data: bytes, size: int, compression: str = "zstd") -> Chunk:
    """Return a chunk of data that is compressed already."""
    return Chunk([], compression, {"data": data, "uncompressed_size": size, "uncompressed_crc": 0})


def packed(records: bytes) -> Chunk:
    """Return a chunk of records."""
    return chunk(zstandard.compress(records), len(records))


def state_of(elements: int) -> Chunk:
    """Return a chunk with one state of so many positions."""
    body = (1).to_bytes(2, "little") + bytes(20) + pb.State(qpos=[0.0] * elements).SerializeToString()
    return packed(Record(0, Opcode.MESSAGE, body).raw)


def many_messages(count: int) -> Chunk:
    """Return a chunk with so many states that say nothing."""
    return packed(count * Record(0, Opcode.MESSAGE, (1).to_bytes(2, "little") + bytes(20)).raw)


def attachments(count: int, data: bytes) -> Iterator[mcap.Attachment]:
    """Yield so many attachments with the same content."""
    return (mcap.Attachment(0, 0, str(number), "", data) for number in range(count))


def sparse(out: Path, size: int) -> None:
    """Make the log's file one with a private record of `size` bytes that the disk does not have."""
    whole = out.read_bytes()
    at = len(whole) - 8
    with out.open("r+b") as stream:
        stream.seek(at)
        stream.write(Record(0, PRIVATE, b"").raw[:1] + size.to_bytes(8, "little"))
        stream.truncate(at + 9 + size)
        stream.seek(0, os.SEEK_END)
        stream.write(whole[-8:])


SPARSE: Final = "private record of 8 GiB"
Change = Callable[[Forgery], object]
GIANTS: Final[dict[str, Change]] = {
    "zstd chunk of 1 GiB": lambda f: f.data.append(chunk(zstd_zeros(GIB), GIB)),
    "zstd chunk of 8 GiB": lambda f: f.data.append(chunk(zstd_zeros(8 * GIB), 8 * GIB)),
    "zstd chunk of 8 GiB that says 1 MiB": lambda f: f.data.append(chunk(zstd_zeros(8 * GIB), MIB)),
    "zstd chunk of 8 GiB whose frame says 1 MiB too": lambda f: f.data.append(chunk(zstd_zeros(8 * GIB, MIB), MIB)),
    "lz4 chunk of 2 GiB": lambda f: f.data.append(chunk(lz4_zeros(2 * GIB), 2 * GIB, "lz4")),
    "lz4 chunk of 2 GiB that says 1 MiB": lambda f: f.data.append(chunk(lz4_zeros(2 * GIB), MIB, "lz4")),
    "200 chunks of 100 MiB": lambda f: f.data.extend([chunk(zstd_zeros(100 * MIB), 100 * MIB)] * 200),
    "200 chunks of 30 MiB": lambda f: f.data.extend([packed(Record(0, PRIVATE, bytes(30 * MIB - 9)).raw)] * 200),
    "200,000 entries of metadata": lambda f: f.metadata().update({str(i): "x" for i in range(200_000)}),
    "metadata of 60 MiB": lambda f: f.metadata().update({"x": "x" * (60 * MIB)}),
    "3 attachments of 60 MiB": lambda f: f.data.extend(attachments(3, bytes(60 * MIB))),
    "100,000 attachments": lambda f: f.data.extend(attachments(100_000, b"")),
    "state of 4,000,000 numbers": lambda f: f.data.append(state_of(4_000_000)),
    "state of 100,000,000 numbers": lambda f: f.data.append(chunk(zstd_zeros(800 * MIB), 800 * MIB)),
    "1,000,000 messages": lambda f: f.data.append(many_messages(1_000_000)),
    "unknown records of no length": lambda f: f.data.append(packed(3_000_000 * Record(0, PRIVATE, b"").raw)),
}


def write(name: str, path: Path) -> None:
    """Write a log of the table."""
    with LogWriter(path, header()) as sink:
        for message in flight(20):
            sink(message)
    if name == SPARSE:
        sparse(path, 8 * GIB)
        return
    forgery = Forgery.of(path.read_bytes())
    GIANTS[name](forgery)
    path.write_bytes(forgery.file())


def tried(command: tuple[str, ...], path: Path) -> bool:
    """Run a command on a log, print what came of it, and return whether that is a fault."""
    with tempfile.TemporaryFile() as told:
        arguments = [sys.executable, "-m", "waypointctl", *command, str(path)]
        process = subprocess.Popen(arguments, stdout=told, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = code = os.waitstatus_to_exitcode(status)
        told.seek(0)
        said = told.read().decode(errors="replace")
    cpu_s, peak = used.ru_utime + used.ru_stime, 1024 * used.ru_maxrss
    is_fault = code not in (0, 1, 2) or "Traceback" in said or cpu_s > MOST_CPU_S or peak > MOST_BYTES
    first = said.replace(str(path), "LOG").partition("\n")[0][:110]
    told_of = f"{' '.join(command):16} {code:3} {cpu_s:5.1f} s {peak / MIB:5.0f} MiB  {first}"
    print(f"  {told_of}{'  FAULT' if is_fault else ''}", flush=True)
    return is_fault


def main() -> None:
    faults = 0
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "giant.mcap"
        for name in (*GIANTS, SPARSE):
            # In a process of its own: a process begins with the largest memory of the one that starts it.
            writer = multiprocessing.get_context("spawn").Process(target=write, args=(name, path))
            writer.start()
            writer.join()
            print(f"{name}: {path.stat().st_blocks * 512 / MIB:.1f} MiB on disk")
            faults += sum(tried(command, path) for command in COMMANDS)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
