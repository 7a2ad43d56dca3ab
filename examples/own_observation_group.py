"""Add an observation group of your own, which feet touch the ground, and fly a policy that observes it.

    python examples/own_observation_group.py

A recipe names groups in `observation: [height, foot_contacts]`; own_reward_term.py describes how to name their file.
The log does not contain the group, so verification needs the plugin again.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import waypointctl

MISSION = waypointctl.Mission.model_validate(
    {"name": "stamp", "policy": "none", "waypoints": [{"position_m": [3.0, 0.0], "timeout_s": 2.0}]}
)


@waypointctl.observation_group(
    name="foot_contacts", unit="1", components=lambda robot: [f"{foot}.contact" for foot in robot.feet]
)
def foot_contacts(view: waypointctl.SimulationView) -> NDArray[np.float64]:
    """Return 1 for each foot on the ground, (n, feet)."""
    return view.contacts.astype(np.float64)


class Stamp(waypointctl.Policy):
    """Pushes the ankle of each leg whose foot is on the ground."""

    robot = "ant"
    observation_layout = ("height", "foot_contacts")

    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return torques (n, 8) as a fraction of the largest."""
        torques = np.zeros((len(observation), 8))
        torques[:, 1::2] = 0.4 * observation[:, 1:]
        return torques


def main() -> None:
    """Fly it, and verify the log with and without the group."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "stamp.mcap")
        waypointctl.fly(MISSION, Stamp(), log=path, plugins=[foot_contacts])
        on_ground = waypointctl.open_log(path).arrays("/observation")["values"][:, 1:].sum(axis=1)
        print(f"{on_ground.mean():.2f} feet on the ground in the mean")
        print(f"with the group: {waypointctl.verify(path, plugins=[foot_contacts]).verdict}")
        print(f"without it: {waypointctl.verify(path).verdict}")


if __name__ == "__main__":
    main()
