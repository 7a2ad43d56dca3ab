"""What logging costs a flight, against the limit: mcap's own writer given the same bytes ready made.

Run: python bench/log_write.py [--seconds 60] [--rounds 7]

Both write the same flight of an ant-sized robot (9 bodies, 8 joints, 31 observations, 8 reward terms, 50 Hz) to
files in one folder, in turns; the ratio is taken per turn, so that a noisy machine disturbs both. Forward kinematics
is the simulation's cost and not counted: the poses are drawn beforehand.
"""

from __future__ import annotations

import argparse
import json
import statistics
import tempfile
from collections.abc import Callable
from itertools import cycle
from pathlib import Path
from time import process_time

import numpy as np
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from waypointctl.log.header import LogHeader
from waypointctl.log.kinematics import Geom
from waypointctl.log.messages import Action, FloatArray, Message, Observation, PlannedWaypoint, Reward, State
from waypointctl.log.writer import LogWriter
from waypointctl.units import NS_PER_S

STEP_NS = NS_PER_S // 50
CHUNK_BYTES = 256 * 1024


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
        terms = tuple((name, float(rng.normal())) for name in ("progress", "energy", "limits", "alive", "fall", "tilt"))
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


def write_bare(path: Path, payloads: list[tuple[int, int, bytes]]) -> None:
    with open(path, "wb") as stream:
        writer = Writer(stream, CHUNK_BYTES, CompressionType.ZSTD, enable_data_crcs=True)
        writer.start(library="bench")
        schema = writer.register_schema("bench", "protobuf", b"")
        channels = {id: writer.register_channel(f"/{id}", "protobuf", schema) for id in {id for id, _, _ in payloads}}
        for channel, time_ns, data in payloads:
            writer.add_message(channels[channel], time_ns, data, time_ns)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated


def ready_made(path: Path) -> list[tuple[int, int, bytes]]:
    with open(path, "rb") as stream:
        found = make_reader(stream).iter_messages(log_time_order=False)
        return [(channel.id, message.log_time, message.data) for _, channel, message in found]


def cpu_s(write: Callable[[], None]) -> float:
    begin = process_time()
    write()
    return process_time() - begin


def measure(seconds: int, rounds: int) -> dict[str, float]:
    messages = flight(seconds * 50)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "flight.mcap"
        write_log(path, messages)
        payloads = ready_made(path)
        ours, bare = [], []
        for _ in range(rounds):
            ours.append(cpu_s(lambda: write_log(path, messages)))
            bare.append(cpu_s(lambda: write_bare(Path(folder) / "bare.mcap", payloads)))
        size = path.stat().st_size
    steps = seconds * 50
    return {
        "records": len(payloads),
        "bytes_per_step": round(size / steps),
        "us_per_step": round(statistics.median(ours) / steps * 1e6, 1),
        "us_per_step_bare": round(statistics.median(bare) / steps * 1e6, 1),
        "records_per_s": round(len(payloads) / statistics.median(ours)),
        "records_per_s_bare": round(len(payloads) / statistics.median(bare)),
        "cost_over_bare": round(statistics.median(a / b for a, b in zip(ours, bare, strict=True)), 2),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="The log writer against mcap's own with bytes ready made.")
    parser.add_argument("--seconds", type=int, default=60, help="of simulated flight")
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    print(json.dumps(measure(options.seconds, options.rounds), indent=2))


if __name__ == "__main__":
    main()
