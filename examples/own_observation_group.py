"""Add an observation group of your own, the phase of a gait, and fly a policy that observes it.

    python examples/own_observation_group.py

A recipe names groups in `observation: [height, gait_phase]`; own_reward_term.py describes how to name their file.
The log does not contain the group, so verification needs it again; of a file, `--plugin FILE` on the command line.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import waypointctl

GAIT_PERIOD_S = 0.5
MISSION = waypointctl.Mission.model_validate(
    {"name": "trot", "policy": "none", "waypoints": [{"position_m": [3.0, 0.0], "timeout_s": 2.0}]}
)


@waypointctl.observation_group(name="gait_phase", unit="1", components=("gait.sine", "gait.cosine"))
def gait_phase(view: waypointctl.SimulationView) -> NDArray[np.float64]:
    """Return the sine and cosine of the gait's phase, (n, 2)."""
    phase = 2 * np.pi * view.time_s / GAIT_PERIOD_S
    return np.stack([np.sin(phase), np.cos(phase)], axis=1)


class Trot(waypointctl.Policy):
    """Swings the hips with the sine of the phase, those of neighbouring legs against each other."""

    robot = "ant"
    observation_layout = ("height", "gait_phase")

    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return torques (n, 8) as a fraction of the largest."""
        torques = np.zeros((len(observation), 8))
        torques[:, ::2] = 0.4 * observation[:, 1:2] * np.array([1.0, -1.0, 1.0, -1.0])
        return torques


def main() -> None:
    """Fly it, and verify the log with and without the group."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "trot.mcap")
        waypointctl.fly(MISSION, Trot(), log=path, plugins=[gait_phase])
        sine = waypointctl.open_log(path).arrays("/observation")["values"][:, 1]
        print(f"{np.sum((sine[:-1] < 0) & (sine[1:] >= 0))} gait periods begun")
        print(f"with the group: {waypointctl.verify(path, plugins=[gait_phase]).verdict.name}")
        print(f"without it: {waypointctl.verify(path).verdict.name}")


if __name__ == "__main__":
    main()
