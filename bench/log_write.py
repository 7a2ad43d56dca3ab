"""What logging costs a flight, against a peer and against the physical limit, in one run.

Run: python bench/log_write.py [--seconds 60] [--rounds 7]

Three write the same records, in turns, to files in one folder, and ratios are taken per turn, so that a noisy machine
disturbs all alike:
  log    the log writer, given messages: it encodes them, translates them for viewers, and writes
  mcap   mcap.writer.Writer, given the bytes of those records ready made
  limit  nothing but zstd, second by second, on those bytes, and the file
Times are the process's CPU time. The robot is ant-sized (9 bodies, 8 joints, 31 observations, 8 reward terms, 50 Hz)
and flies nowhere: its numbers are random, which is the worst case for zstd. Forward kinematics is the simulation's
cost and not counted: the poses are drawn beforehand.
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
from collections.abc import Callable
from itertools import cycle, groupby
from pathlib import Path
from time import process_time
from typing import TypeAlias

import numpy as np
import zstandard
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from waypointctl.log.channels import CHUNK_BYTES
from waypointctl.log.chunk import ZSTD_LEVEL
from waypointctl.log.header import LogHeader
from waypointctl.log.messages import Action, FloatArray, Message, Observation, PlannedWaypoint, Reward, State
from waypointctl.log.writer import LogWriter
from waypointctl.sim.geometry import Geom
from waypointctl.task.reward import TERMS
from waypointctl.units import NS_PER_S

STEP_NS = NS_PER_S // 50

Payload: TypeAlias = tuple[int, int, bytes]  # channel, log time [ns], data


class RandomAnt:
    """The ant's bodies and joints, anywhere."""

    body_names = ("torso", *(f"{leg}_{part}" for leg in ("fl", "fr", "bl", "br") for part in ("thigh", "shin")))
    joint_names = tuple(f"{leg}_{part}" for leg in ("fl", "fr", "bl", "br") for part in ("hip", "ankle"))
    geoms = tuple(
        Geom(body, "capsule", (0, 0, 0), (1, 0, 0, 0), (0.08, 0.2, 0), (0.8, 0.6, 0.4, 1)) for body in body_names
    )

    def __init__(self) -> None:
        """Draw poses, so many that zstd finds no two alike near each other."""
        rng = np.random.default_rng(0)
        self._poses = cycle([(rng.normal(size=(9, 3)), rng.normal(size=(9, 4))) for _ in range(1000)])

    def poses(self, qpos: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the next of the drawn poses."""
        return next(self._poses)


def flight(steps: int) -> list[Message]:
    rng = np.random.default_rng(1)
    messages: list[Message] = []
    for step in range(steps):
        now = step * STEP_NS
        action = rng.normal(size=8)
        terms = tuple((name, float(rng.normal())) for name in (term.name for term in TERMS))
        messages += [
            State(now, step, rng.normal(size=15), rng.normal(size=14), rng.normal(size=14)),
            Observation(now, step, rng.normal(size=31)),
            Action(now, step, "policy", action, np.clip(action, -1, 1)),
            Reward(now + STEP_NS, step, terms, 1.0),
        ]
    return messages


def write_log(path: Path, messages: list[Message]) -> None:
    waypoint = PlannedWaypoint(0, "goal", 14.0, 14.0, "box", 0.5, 10 * NS_PER_S, 0)
    with LogWriter(path, LogHeader("ant", RandomAnt(), (waypoint,), (), {})) as sink:
        for message in messages:
            sink(message)


def write_mcap(path: Path, payloads: list[Payload]) -> None:
    with open(path, "wb") as stream:
        writer = Writer(stream, CHUNK_BYTES, CompressionType.ZSTD, enable_data_crcs=True)
        writer.start(library="bench")
        schema = writer.register_schema("bench", "protobuf", b"")
        channels = {id: writer.register_channel(f"/{id}", "protobuf", schema) for id in {id for id, _, _ in payloads}}
        for channel, time_ns, data in payloads:
            writer.add_message(channels[channel], time_ns, data, time_ns)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated


def write_limit(path: Path, payloads: list[Payload]) -> None:
    compressor = zstandard.ZstdCompressor(level=ZSTD_LEVEL)
    with open(path, "wb") as stream:
        for _, second in groupby(payloads, key=lambda payload: payload[1] // NS_PER_S):
            stream.write(compressor.compress(b"".join([data for _, _, data in second])))


def ready_made(path: Path) -> list[Payload]:
    with open(path, "rb") as stream:
        found = make_reader(stream).iter_messages(log_time_order=False)
        return [(channel.id, message.log_time, message.data) for _, channel, message in found]


def cpu_s(write: Callable[[], None]) -> float:
    begin = process_time()
    write()
    return process_time() - begin


def measure(seconds: int, rounds: int) -> dict[str, float]:
    messages, steps = flight(seconds * 50), seconds * 50
    with tempfile.TemporaryDirectory() as folder:
        path, other = Path(folder) / "flight.mcap", Path(folder) / "other"
        write_log(path, messages)
        payloads = ready_made(path)
        turns = [
            (
                cpu_s(lambda: write_log(path, messages)),
                cpu_s(lambda: write_mcap(other, payloads)),
                cpu_s(lambda: write_limit(other, payloads)),
            )
            for _ in range(rounds)
        ]
        size = path.stat().st_size
    log, mcap, limit = (statistics.median(times) for times in zip(*turns, strict=True))
    return {
        "records": len(payloads),
        "bytes_per_step": round(size / steps),
        "us_per_step": round(log / steps * 1e6, 1),
        "us_per_step_mcap": round(mcap / steps * 1e6, 1),
        "us_per_step_limit": round(limit / steps * 1e6, 1),
        "records_per_s": round(len(payloads) / log),
        "ratio_to_mcap": round(statistics.median(ours / theirs for ours, theirs, _ in turns), 2),
        "ratio_to_limit": round(statistics.median(ours / least for ours, _, least in turns), 2),
    }


def main() -> None:
    parser = argparse.ArgumentParser(
        description="The log writer against mcap's own, and against zstd alone, with bytes ready made."
    )
    parser.add_argument("--seconds", type=int, default=60, help="of simulated flight")
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    print(json.dumps(measure(options.seconds, options.rounds), indent=2))


if __name__ == "__main__":
    main()
