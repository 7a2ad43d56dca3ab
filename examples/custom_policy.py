"""Fly your own policy class that is not a network: a gait of sines, with a state.

    python examples/custom_policy.py

The log names the class and does not contain it. Verification simulates the states again from the logged actions, bit
for bit, and reports that the actions were not computed again.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import waypointctl

MISSION = waypointctl.Mission.model_validate(
    {"name": "wriggle", "policy": "none", "waypoints": [{"position_m": [3.0, 0.0], "timeout_s": 4.0}]}
)


class Wriggle(waypointctl.Policy):
    """Swings each joint, a quarter of a period after the one before it."""

    robot = "ant"
    observation_layout = "egocentric"

    def __init__(self) -> None:
        """Begin in the middle of the swing."""
        self.phase = np.zeros((1, 1))  # (n, 1) [rad]

    def reset(self, mask: NDArray[np.bool_]) -> None:
        """Begin the swing anew."""
        self.phase = np.where(mask[:, np.newaxis], 0.0, np.resize(self.phase, (len(mask), 1)))

    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return torques (n, 8) as a fraction of the largest."""
        self.phase = self.phase + 0.2
        return 0.3 * np.sin(self.phase + np.arange(8) * np.pi / 2)

    def state(self) -> dict[str, NDArray[np.float64]]:
        """Return the phase, for the log's checkpoints."""
        return {"phase": self.phase}

    def restore(self, state: waypointctl.PolicyState) -> None:
        """Continue from a checkpoint."""
        self.phase = state["phase"]


def main() -> None:
    """Fly it, and verify the log."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "wriggle.mcap")
        result = waypointctl.fly(MISSION, Wriggle(), log=path)
        print(f"{result.outcome}: {result.reason}")
        verification = waypointctl.verify(path)
        print(f"{verification.verdict.name}: {verification.reason}")
        for line in verification.not_compared:
            print(f"not compared: {line}")


if __name__ == "__main__":
    main()
