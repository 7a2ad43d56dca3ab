"""Whether a flight's cost is linear in its length: CPU seconds a simulated second, at three lengths.

Run: python bench/flight_length.py [--rounds 12,48,192] [--kinds steered,joint] [--stages record,replay]

Each kind of flight walks rounds of four waypoints. For each length the flight is recorded, its log is read, summarised
and replayed, and, cut at nine tenths, resumed. The ratio is what a simulated second costs in the longest flight divided
by what it costs in the shortest one: 1 is linear.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from time import process_time
from typing import Final

os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})  # before any library starts its threads

from waypointctl.flight.fly import fly  # noqa: E402
from waypointctl.log.messages import Message  # noqa: E402
from waypointctl.log.reader import open_log  # noqa: E402
from waypointctl.mission.files import MissionFile, load_mission  # noqa: E402
from waypointctl.policy.bundle import LoadedPolicy, load_policy  # noqa: E402
from waypointctl.replay.resume import go_on, unfinished  # noqa: E402
from waypointctl.replay.summary_builder import summarize  # noqa: E402
from waypointctl.replay.verify import Verdict, verify_log  # noqa: E402

POLICY: Final = Path(__file__).parents[1] / "policies" / "ant-waypoint"
SQUARE: Final = "[[3, 0], [3, 3], [0, 3], [0, 0]]"
ROUND_S: Final = 7.0  # what a round takes, roughly
KINDS: Final = {
    "mission": "autonomy: mission",
    "waypoint": "autonomy: waypoint",
    "lossy": "autonomy: waypoint\nlink: {loss: 20 %}\ncommands: {retries: 50}",
    "steered": "autonomy: short_range_goal\noperator: {steering: continuous, update_rate: 10 Hz, lookahead: 2 m}",
    "joint": "autonomy: joint\nlink: {delay: 0 s}",
}
STAGES: Final = ("record", "read", "summary", "replay", "resume")


def mission_of(kind: str, rounds: int) -> str:
    """Return the text of a mission of some rounds."""
    head = f"name: {kind}\npolicy: {POLICY}\nrepeat: {rounds}\nwaypoints: {SQUARE}\n"
    rest = "defaults: {timeout: 10 min}\non_failure: skip\n"
    if kind == "scheduled":
        return f"{head}{rest}schedule:\n{schedule(rounds)}\n"
    return f"{head}{rest}{KINDS[kind]}\n"


def schedule(rounds: int) -> str:
    """Return a command for every second, most of them kept on board until their time."""
    count = min(round(rounds * ROUND_S), 1000)
    step_s = rounds * ROUND_S / count
    lines = []
    for place in range(count):
        at_s = step_s * place
        lines.append(
            f"  - {{at: {at_s / 2:.3f} s, not_before: {at_s:.3f} s, do: set_timeout, timeout: {600 + place} s}}"
        )
    return "\n".join(lines)


def measure(text: str, policy: LoadedPolicy, folder: Path, stages: Sequence[str]) -> dict[str, float]:
    """Return the CPU time of each stage [s], the simulated time [s] and the log's size [MB]."""
    path, source = folder / "flight.mcap", folder / "mission.yaml"
    source.write_text(text)
    mission_file = load_mission(source)
    cpu_s = {"record": timed(lambda: _record(mission_file, policy, path))}
    log, size = open_log(path), path.stat().st_size
    if "resume" in stages:
        cut = folder / "cut.mcap.part"
        cut.write_bytes(path.read_bytes()[: size * 9 // 10])
    works: dict[str, Callable[[], None]] = {
        "read": lambda: _forget(deque(log.messages(), maxlen=0)),
        "summary": lambda: _forget(summarize(log.messages())),
        "replay": lambda: _replay(path),
        "resume": lambda: _resume(cut),
    }
    cpu_s |= {stage: timed(work) for stage, work in works.items() if stage in stages}
    return {"simulated_s": log.duration_s, "log_mb": size / 1e6, **cpu_s}


def _record(mission_file: MissionFile, policy: LoadedPolicy, path: Path) -> None:
    fly(mission_file, policy, log=path)


def _replay(path: Path) -> None:
    found = verify_log(open_log(path))
    assert found.verdict is Verdict.EXACT, found.reason


def _resume(part: Path) -> None:
    with unfinished(part) as flight:
        assert flight is not None
        go_on(flight, again=_ignore, watch=_ignore)


def _forget(_: object) -> None:
    return


def _ignore(_: Message) -> None:
    return


def timed(work: Callable[[], None]) -> float:
    """Return the CPU time of a piece of work [s]."""
    before = process_time()
    work()
    return process_time() - before


def print_kind(kind: str, found: Mapping[int, Mapping[str, float]], stages: Sequence[str]) -> None:
    """Print a table of one kind of flight: a line a length, then the ratios."""
    print(f"\n{kind}: CPU ms a simulated second")
    print(f"{'simulated':>10} {'log kB/s':>9}" + "".join(f"{stage:>9}" for stage in stages))
    costs = []
    for one in found.values():
        per_s = {key: one[key] / one["simulated_s"] * 1000 for key in ("log_mb", *stages)}
        costs.append(per_s)
        row = "".join(f"{per_s[stage]:>9.1f}" for stage in stages)
        print(f"{one['simulated_s']:>8.0f} s {per_s['log_mb']:>9.1f}{row}")
    ratios = {key: costs[-1][key] / costs[0][key] for key in costs[0]}
    print(f"{'ratio':>10} {ratios['log_mb']:>9.2f}" + "".join(f"{ratios[stage]:>9.2f}" for stage in stages), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description="Whether a flight's cost is linear in its length.")
    every = [*KINDS, "scheduled"]
    parser.add_argument("--rounds", default="12,48,192", help="lengths, a round is some 7 s; default: %(default)s")
    parser.add_argument("--kinds", default=",".join(every), help="of flights; default: %(default)s")
    parser.add_argument("--stages", default=",".join(STAGES), help="record, and what else; default: %(default)s")
    options = parser.parse_args()
    stages = [stage for stage in STAGES if stage in ("record", *options.stages.split(","))]
    lengths = [int(part) for part in options.rounds.split(",")]
    policy = load_policy(POLICY)
    for kind in options.kinds.split(","):
        found = {}
        for rounds in lengths:
            with tempfile.TemporaryDirectory() as folder:
                found[rounds] = measure(mission_of(kind, rounds), policy, Path(folder), stages)
        print_kind(kind, found, stages)


if __name__ == "__main__":
    main()
