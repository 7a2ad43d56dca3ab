"""A flight whose process is killed, again and again, does each thing once."""

from __future__ import annotations

import random
import subprocess
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.cli.flying import start
from waypointctl.log.messages import Event, EventKind
from waypointctl.log.reader import open_log
from waypointctl.policy.bundle import LoadedPolicy

LIMIT_S = 300.0
REPOSITORY = Path(__file__).parents[2]

# Waypoints under the robot's feet: it stands through the mission, whatever its policy does.
STANDING = """\
name: round
seed: 4
policy: still
defaults: {tolerance: 3 m, hold: 600 ms, observe: true}
link: {delay: 0.5 s, jitter: 20 ms, loss: 5 %}
waypoints:
""" + "".join(f"  - {{name: stop-{number}, position: [0.{number} m, 0 m]}}\n" for number in range(3))

ROUND_M = ((3, 1), (5, 3), (7, 5), (9, 5), (11, 7), (11, 9), (9, 11), (7, 11), (5, 9), (3, 7))
WALKING = f"""\
name: round
seed: 4
policy: {REPOSITORY / "policies" / "ant-waypoint"}
defaults: {{tolerance: 0.8 m, hold: 300 ms, timeout: 30 s, observe: true}}
link: {{delay: 0.5 s, jitter: 20 ms, loss: 5 %}}
waypoints:
""" + "".join(f"  - {{position: [{x_m} m, {y_m} m]}}\n" for x_m, y_m in ROUND_M)


@dataclass(frozen=True)
class Uninterrupted:
    """The flight as it is when nobody kills it."""

    folder: Path
    data: bytes
    begin: int  # before this byte its log is none
    waypoints: int


def fly_whole(folder: Path, mission: str) -> Uninterrupted:
    (folder / "round.yaml").write_text(mission)
    done = start(folder, "run", "round.yaml", "--out", "whole.mcap", stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    out, err = done.communicate(timeout=LIMIT_S)
    assert done.returncode == 0, (out, err)
    data = (folder / "whole.mcap").read_bytes()
    begin = open_log(folder / "whole.mcap").index.chunks[0].offset
    return Uninterrupted(folder, data, begin, mission.count("position:"))


def kill_at(folder: Path, size: int, *arguments: str) -> bool:
    """Start waypointctl and kill it when a log that it writes has come to a size; return whether it was killed."""
    flight = start(folder, "run", *arguments, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    ends_s = time.monotonic() + LIMIT_S
    written = (folder / "flight.mcap.part", folder / "flight.mcap.resumed.part")
    at_first = {path: path.stat() for path in written if path.exists()}
    while flight.poll() is None and time.monotonic() < ends_s:
        for path in written:
            try:
                now = path.stat()
            except FileNotFoundError:
                continue
            is_new = path not in at_first or at_first[path].st_ino != now.st_ino
            if is_new and now.st_size >= size:
                flight.kill()
        time.sleep(0.0005)
    flight.wait(LIMIT_S)
    return flight.returncode == -9


def survive(whole: Uninterrupted, rng: random.Random, most_kills: int) -> int:
    """Kill the flight, and what goes on with it, up to so many times; return how often that was."""
    folder = whole.folder
    for path in folder.glob("flight.mcap*"):
        path.unlink()

    def somewhere() -> int:
        return rng.randint(whole.begin + 1, len(whole.data) - 1)

    kills = int(kill_at(folder, somewhere(), "round.yaml", "--out", "flight.mcap"))
    while kills < most_kills and (folder / "flight.mcap.part").exists():
        kills += kill_at(folder, somewhere(), "--resume", "flight.mcap.part")
    if (folder / "flight.mcap.part").exists():
        done = start(folder, "run", "--resume", "flight.mcap.part", stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        out, err = done.communicate(timeout=LIMIT_S)
        assert done.returncode == 0, (out, err)
    return kills


def require_done_once(whole: Uninterrupted) -> None:
    """Require every waypoint and task done exactly once, and the bytes of the flight that nobody killed."""
    path = whole.folder / "flight.mcap"
    events = [message for message in open_log(path).messages(("/event",)) if isinstance(message, Event)]
    for kind in (EventKind.WAYPOINT_REACHED, EventKind.HOLD_COMPLETED, EventKind.OBSERVATION_TAKEN):
        done = Counter(event.waypoint for event in events if event.kind is kind)
        assert done == dict.fromkeys(range(whole.waypoints), 1), kind
    assert events[-1].text.startswith(f"success: {whole.waypoints} of {whole.waypoints} waypoints reached")
    assert path.read_bytes() == whole.data
    assert sorted(each.name for each in whole.folder.glob("flight.mcap*")) == ["flight.mcap"]


@pytest.mark.slow
def test_a_flight_killed_twice_in_a_row_does_each_thing_once(
    tmp_path: Path, make_policy: Callable[..., LoadedPolicy]
) -> None:
    make_policy(tmp_path / "still", gain=0.0)
    whole = fly_whole(tmp_path, STANDING)
    assert survive(whole, random.Random(1), 2) >= 1
    require_done_once(whole)


@pytest.mark.slow
def test_flights_killed_at_fifty_random_moments_do_each_thing_once(tmp_path: Path) -> None:
    whole = fly_whole(tmp_path, WALKING)
    rng = random.Random(50)
    kills = 0
    while kills < 50:
        kills += survive(whole, rng, rng.randint(1, 4))
        require_done_once(whole)
