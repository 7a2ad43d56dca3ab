"""Fly a mission, check its log bit for bit, and read what is in it.

python examples/fly_and_read_log.py [MISSION.yaml]
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np

import waypointctl
from waypointctl import messages

MISSIONS = Path(__file__).parents[1] / "missions"


def main(mission: Path) -> None:
    """Fly, verify, read."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "flight.mcap")
        result = waypointctl.fly(mission, policy="ant-waypoint", log=path)
        print(f"{result.outcome}: {result.reason}")
        print(f"verified: {waypointctl.verify(path).verdict.name}")

        with waypointctl.open_log(path) as log:
            for message in log.messages("/event"):
                assert isinstance(message, messages.Event)
                print(f"{message.time_ns / 1e9:8.2f} s  {message.clock:8}  {message.text}")
            states = log.arrays("/state")
            length_m = np.linalg.norm(np.diff(states["qpos"][:, :2], axis=0), axis=1).sum()
            print(f"{log.summary.reached} waypoints reached, {length_m:.1f} m in {len(states['step'])} control steps")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mission", type=Path, nargs="?", default=MISSIONS / "paper-two-point-moon.yaml")
    main(parser.parse_args().mission)
