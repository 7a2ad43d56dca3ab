"""Logs mutated at random, by a seed: bytes of the file, records of it, what they say; checksums made right again."""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np
from mcap import records as mcap
from mcap.exceptions import McapError
from mcap.opcode import Opcode

from tests.log.attacks import ATTACKS, PRIVATE
from tests.log.forging import Chunk, Forgery, with_payload
from waypointctl.log.chunk import encoded
from waypointctl.log.records import Record
from waypointctl.replay.contents import PROGRAM

Random = np.random.Generator
FileMutation = Callable[[bytes, Random], bytes]
Mutation = Callable[[Forgery, Random], None]

TIMES_AT: Final = 6  # of a message's body, after channel and sequence
PAYLOAD_AT: Final = 22
AWKWARD: Final = (0, 1, 2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**62, 2**63 - 1, 2**63, 2**64 - 1)


def mutated(bases: list[bytes], rng: Random) -> tuple[str, bytes]:
    """Return a mutation of one of some logs, and what was done, in words."""
    base = bases[rng.integers(len(bases))]
    if rng.random() < 0.25:
        names = [str(rng.choice([*FILE_MUTATIONS])) for _ in range(rng.integers(1, 3))]
        for name in names:
            base = FILE_MUTATIONS[name](base, rng)
        return "+".join(names), base
    forgery = Forgery.of(base)
    names = [str(name) for name in rng.choice([*MUTATIONS], size=int(rng.choice([1, 1, 1, 2, 3])))]
    for name in [*names, *(["claim"] if rng.random() < 0.3 else [])]:
        try:
            MUTATIONS[name](forgery, rng)
        except (StopIteration, LookupError, ValueError, McapError, struct.error):
            continue  # an earlier mutation has taken away, or damaged, what this one changes
    return "+".join(names), forgery.file()


# Bytes of the file


def flip_bits(file: bytes, rng: Random) -> bytes:
    changed = bytearray(file)
    for _ in range(rng.integers(1, 9)):
        changed[_place(changed, rng)] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def overwrite(file: bytes, rng: Random) -> bytes:
    at = _place(file, rng)
    return file[:at] + rng.bytes(int(rng.integers(1, 64))) + file[at:][int(rng.integers(64)) :]


def write_number(file: bytes, rng: Random) -> bytes:
    at, size = _place(file, rng), int(rng.choice([2, 4, 8]))
    number = AWKWARD[rng.integers(len(AWKWARD))] % (1 << 8 * size)
    return file[:at] + number.to_bytes(size, "little") + file[at + size :]


def delete(file: bytes, rng: Random) -> bytes:
    at = _place(file, rng)
    return file[:at] + file[at + int(rng.integers(1, 5000)) :]


def repeat(file: bytes, rng: Random) -> bytes:
    at, size = _place(file, rng), int(rng.integers(1, 5000))
    return file[: at + size] + file[at:]


def truncate(file: bytes, rng: Random) -> bytes:
    return file[: _place(file, rng)]


def append(file: bytes, rng: Random) -> bytes:
    return file + rng.bytes(int(rng.integers(1, 100)))


def _place(file: bytes | bytearray, rng: Random) -> int:
    """Return a place in a file: half of them near its ends, where records of every kind stand."""
    size = len(file)
    near = int(rng.integers(min(size, 600)))
    return int(rng.choice([near, size - 1 - near, *(int(rng.integers(size)) for _ in range(2))]))


# What records say


def attack(forgery: Forgery, rng: Random) -> None:
    ATTACKS[str(rng.choice([*ATTACKS]))](forgery)


def change_payload(forgery: Forgery, rng: Random) -> None:
    chunk, at = _message(forgery, rng)
    chunk.inner[at] = (Opcode.MESSAGE, with_payload(chunk.inner[at][1], lambda data: _changed(data, rng)))


def change_number(forgery: Forgery, rng: Random) -> None:
    """Turn a bit of one of the doubles that nearly every message consists of."""

    def change(data: bytes) -> bytes:
        at = int(rng.integers(max(1, len(data) - 8)))
        return data[:at] + bytes([data[at] ^ 1 << int(rng.integers(8))]) + data[at + 1 :]

    chunk, at = _message(forgery, rng)
    chunk.inner[at] = (Opcode.MESSAGE, with_payload(chunk.inner[at][1], change))


def hide_in_payload(forgery: Forgery, rng: Random) -> None:
    """Add a field that no schema knows: every parser of protobuf skips it."""
    chunk, at = _message(forgery, rng)
    field = b"\x82\x7d\x06hidden"  # number 2000, six bytes
    chunk.inner[at] = (Opcode.MESSAGE, with_payload(chunk.inner[at][1], lambda data: data + field))


def change_head(forgery: Forgery, rng: Random) -> None:
    """Change channel, sequence or a time of a message."""
    chunk, at = _message(forgery, rng)
    body = bytearray(chunk.inner[at][1])
    place, size = [(0, 2), (2, 4), (TIMES_AT, 8), (TIMES_AT + 8, 8)][rng.integers(4)]
    old = int.from_bytes(body[place : place + size], "little")
    new = int(rng.choice([old + 1, old ^ 1 << int(rng.integers(8 * size)), 0])) if size < 8 else old + 1
    body[place : place + size] = (new % (1 << 8 * size)).to_bytes(size, "little")
    chunk.inner[at] = (Opcode.MESSAGE, bytes(body))


def drop_message(forgery: Forgery, rng: Random) -> None:
    chunk, at = _message(forgery, rng)
    del chunk.inner[at]


def repeat_message(forgery: Forgery, rng: Random) -> None:
    chunk, at = _message(forgery, rng)
    other, to = _message(forgery, rng)
    other.inner.insert(to, chunk.inner[at])


def swap_messages(forgery: Forgery, rng: Random) -> None:
    (a, at), (b, to) = _message(forgery, rng), _message(forgery, rng)
    a.inner[at], b.inner[to] = b.inner[to], a.inner[at]


def swap_payloads(forgery: Forgery, rng: Random) -> None:
    (a, at), (b, to) = _message(forgery, rng), _message(forgery, rng)
    first, second = a.inner[at][1], b.inner[to][1]
    a.inner[at] = (Opcode.MESSAGE, first[:PAYLOAD_AT] + second[PAYLOAD_AT:])
    b.inner[to] = (Opcode.MESSAGE, second[:PAYLOAD_AT] + first[PAYLOAD_AT:])


def change_definition(forgery: Forgery, rng: Random) -> None:
    kinds = (Opcode.SCHEMA, Opcode.CHANNEL)
    places = [(chunk, at) for chunk in forgery.chunks for at, record in enumerate(chunk.inner) if record[0] in kinds]
    chunk, at = places[rng.integers(len(places))]
    opcode, body = chunk.inner[at]
    chunk.inner[at] = (opcode, _changed(body, rng))


def unknown_inner(forgery: Forgery, rng: Random) -> None:
    chunk, at = _message(forgery, rng)
    opcode = int(rng.choice([0, PRIVATE, *map(int, Opcode), 255]))
    chunk.inner.insert(at, (opcode, rng.bytes(int(rng.integers(0, 60)))))


def unknown_record(forgery: Forgery, rng: Random) -> None:
    opcode = int(rng.choice([0, PRIVATE, *map(int, Opcode), 255]))
    record = Record(0, opcode, rng.bytes(int(rng.integers(0, 200)))).raw
    forgery.data.insert(int(rng.integers(len(forgery.data) + 1)), record)


def drop_record(forgery: Forgery, rng: Random) -> None:
    del forgery.data[int(rng.integers(len(forgery.data)))]


def repeat_record(forgery: Forgery, rng: Random) -> None:
    at, to = rng.integers(len(forgery.data), size=2)
    forgery.data.insert(int(to), forgery.data[at])


def swap_records(forgery: Forgery, rng: Random) -> None:
    at, to = rng.integers(len(forgery.data), size=2)
    forgery.data[at], forgery.data[to] = forgery.data[to], forgery.data[at]


def repack(forgery: Forgery, rng: Random) -> None:
    for chunk in forgery.chunks:
        chunk.compression = str(rng.choice(["", "lz4", "zstd"]))


def split_chunk(forgery: Forgery, rng: Random) -> None:
    chunk, at = _message(forgery, rng)
    forgery.data.insert(forgery.data.index(chunk) + 1, Chunk(chunk.inner[at:], chunk.compression))
    del chunk.inner[at:]


def lying_chunk(forgery: Forgery, rng: Random) -> None:
    chunk = forgery.chunks[rng.integers(len(forgery.chunks))]
    name = str(rng.choice(["message_start_time", "message_end_time", "uncompressed_size", "uncompressed_crc"]))
    chunk.lies[name] = AWKWARD[rng.integers(len(AWKWARD))] % (2**32 if name.endswith("crc") else 2**64)


def lying_index(forgery: Forgery, rng: Random) -> None:
    chunk = forgery.chunks[rng.integers(len(forgery.chunks))]
    name = str(rng.choice(["message_start_time", "message_end_time", "chunk_start_offset", "chunk_length"]))
    chunk.index_lies[name] = int(rng.choice([0, 8, 1000])) if rng.random() < 0.5 else AWKWARD[rng.integers(10)]


def change_summary(forgery: Forgery, rng: Random) -> None:
    """Drop, repeat or move a record of the summary."""
    before, what, where = forgery.summary, int(rng.integers(3)), rng.random(2)

    def change(listed: list[mcap.McapRecord]) -> list[mcap.McapRecord]:
        *body, footer = before(listed)
        at, to = (int(place * len(body)) for place in where)
        record = body[at]
        if what != 1:
            del body[at]
        if what != 0:
            body.insert(to, record)
        return [*body, footer]

    forgery.summary = change


def change_metadata(forgery: Forgery, rng: Random) -> None:
    metadata = forgery.metadata()
    key = str(rng.choice([*metadata]))
    text = metadata[key]
    metadata[key] = [f"{text}0", "", "\x1b[31m\u202e", "9" * 3000, text[::-1], "nan"][rng.integers(6)]


def claim(forgery: Forgery, rng: Random) -> None:
    """Say that another program or processor wrote the log."""
    keys = rng.choice([*PROGRAM], size=int(rng.integers(1, 4)), replace=False)
    forgery.metadata().update({str(key): "0.0" for key in keys})


def change_attachment(forgery: Forgery, rng: Random) -> None:
    attachment = _attachment(forgery, rng)
    attachment.data = _changed(attachment.data, rng)


def change_attachment_and_its_hash(forgery: Forgery, rng: Random) -> None:
    attachment, metadata = _attachment(forgery, rng), forgery.metadata()
    before = hashlib.sha256(attachment.data).hexdigest()
    attachment.data = _changed(attachment.data, rng)
    after = hashlib.sha256(attachment.data).hexdigest()
    manifest = forgery.attachment("policy/manifest.json")
    told = hashlib.sha256(manifest.data).hexdigest()
    if attachment is not manifest:
        manifest.data = manifest.data.replace(before.encode(), after.encode())
    hashes = {before: after, told: hashlib.sha256(manifest.data).hexdigest()}
    metadata.update({key: hashes.get(text, text) for key, text in metadata.items()})


def comment_in_mission(forgery: Forgery, rng: Random) -> None:
    attachment, metadata = forgery.attachment("mission.yaml"), forgery.metadata()
    attachment.data += b"# " + str(int(rng.integers(1 << 30))).encode() + b"\n"
    metadata["sha256_mission"] = hashlib.sha256(attachment.data).hexdigest()


def change_header(forgery: Forgery, rng: Random) -> None:
    field = str(rng.choice(["profile", "library"]))
    forgery.header = replace(forgery.header, **{field: str(rng.choice(["", "ros2", "x" * 5000, "\x1b[2J"]))})


def bytes_behind(forgery: Forgery, rng: Random) -> None:
    """Let a record be longer than what it says."""
    at = int(rng.integers(len(forgery.data)))
    part = forgery.data[at]
    if isinstance(part, mcap.McapRecord):
        raw = encoded(part)
        forgery.data[at] = Record(0, raw[0], raw[9:] + rng.bytes(int(rng.integers(1, 30)))).raw


def _changed(data: bytes, rng: Random) -> bytes:
    if not data:
        return rng.bytes(3)
    at, size = int(rng.integers(len(data))), int(rng.integers(1, 9))
    match int(rng.integers(5)):
        case 0:
            return data[:at] + rng.bytes(size) + data[at + size :]
        case 1:
            return data[:at] + data[at + size :]
        case 2:
            return data[: at + size] + data[at:]
        case 3:
            return data[:at]
        case _:
            return data[:at] + bytes([data[at] ^ 1 << int(rng.integers(8))]) + data[at + 1 :]


def _attachment(forgery: Forgery, rng: Random) -> mcap.Attachment:
    found = [part for part in forgery.data if isinstance(part, mcap.Attachment)]
    return found[rng.integers(len(found))]


def _message(forgery: Forgery, rng: Random) -> tuple[Chunk, int]:
    """Return the place of a message: any of any channel, however few messages that has."""
    by_channel: dict[bytes, list[tuple[Chunk, int]]] = {}
    for chunk in forgery.chunks:
        for at, (opcode, body) in enumerate(chunk.inner):
            if opcode == Opcode.MESSAGE and len(body) >= PAYLOAD_AT:
                by_channel.setdefault(body[:2], []).append((chunk, at))
    places = [*by_channel.values()][rng.integers(len(by_channel))]
    return places[rng.integers(len(places))]


FILE_MUTATIONS: Final[dict[str, FileMutation]] = {
    each.__name__: each for each in (flip_bits, overwrite, write_number, delete, repeat, truncate, append)
}
MUTATIONS: Final[dict[str, Mutation]] = {
    each.__name__: each
    for each in (
        attack,
        bytes_behind,
        change_attachment,
        change_attachment_and_its_hash,
        change_definition,
        change_head,
        change_header,
        change_metadata,
        change_number,
        change_payload,
        change_summary,
        claim,
        comment_in_mission,
        drop_message,
        drop_record,
        hide_in_payload,
        lying_chunk,
        lying_index,
        repack,
        repeat_message,
        repeat_record,
        split_chunk,
        swap_messages,
        swap_payloads,
        swap_records,
        unknown_inner,
        unknown_record,
    )
}
