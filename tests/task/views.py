"""Views of robots that stand anywhere, for tests."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from waypointctl.robots.load import load_robot
from waypointctl.task.observation import Layout, layout
from waypointctl.task.view import SimulationView, body_of

FloatArray = NDArray[np.float64]

ANT = load_robot("ant")


def ant_layout(name: str) -> Layout:
    return layout(name, ANT)


def view_of(qpos: FloatArray, qvel: FloatArray, goals: FloatArray | None = None, **others: Any) -> SimulationView:
    """Return a view of ants at qpos (n, nq) and qvel (n, nv); what is not given is 0."""
    n = len(qpos)
    given: dict[str, Any] = {
        "goals": np.zeros((n, 2, 2)) if goals is None else goals,
        "noise": np.zeros((n, 4)),
        "action": np.zeros((n, ANT.num_actions)),
        "steps": np.zeros(n, np.int64),
    }
    return SimulationView(robot=ANT, body=body_of(qpos, qvel), qpos=qpos, **(given | others))
