"""Read a log into pandas: telemetry joined with the true position at the arrival of each frame.

python examples/log_to_pandas.py [LOG.mcap]
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import pandas as pd

import waypointctl

MISSIONS = Path(__file__).parents[1] / "missions"


def table(log: waypointctl.FlightLog, topic: str) -> pd.DataFrame:
    """Return the messages of a topic as rows; a column that is an array of numbers becomes one for each number."""
    columns: dict[str, object] = {}
    for name, values in log.arrays(topic).items():
        several = values.ndim == 2
        columns |= {f"{name}[{i}]": values[:, i] for i in range(values.shape[1])} if several else {name: values}
    return pd.DataFrame(columns)


def main(path: Path) -> None:
    """Print how far telemetry was from the robot's true position when it arrived."""
    log = waypointctl.open_log(path)
    telemetry, state = table(log, "/telemetry"), table(log, "/state")
    frames = telemetry.sort_values("received_ns")
    merged = pd.merge_asof(frames, state, left_on="received_ns", right_on="time_ns")
    error_m = ((merged["x_m"] - merged["qpos[0]"]) ** 2 + (merged["y_m"] - merged["qpos[1]"]) ** 2) ** 0.5
    print(f"{len(state)} states, {len(telemetry)} telemetry frames")
    print(error_m.describe().to_string())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log", type=Path, nargs="?", help="a log; without it a mission is flown")
    given = parser.parse_args().log
    if given:
        main(given)
    else:
        with tempfile.TemporaryDirectory() as folder:
            flown = Path(folder, "flight.mcap")
            waypointctl.fly(MISSIONS / "paper-two-point-moon.yaml", "ant-waypoint", log=flown)
            main(flown)
