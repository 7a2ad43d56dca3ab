"""A navigator between plan and policy: what it gives is what the policy observes, and its state is in checkpoints."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.flight.flying import STILL, Scripted, flown, mission_of, only
from waypointctl.errors import InputError
from waypointctl.flight.fly import fly
from waypointctl.log.messages import Checkpoint, Message, Observation
from waypointctl.replay.verify import Verdict, verify
from waypointctl.task.view import Body

AHEAD = {"position_m": [5.0, 0.0], "timeout_s": 0.2}
ASIDE = {"position_m": [0.0, 5.0], "timeout_s": 0.2}


class Detour:
    """Leads the policy to a place that is none of the plan's."""

    def __init__(self) -> None:
        self.calls = 0

    def goals(self, body: Body, waypoints: NDArray[np.float64]) -> NDArray[np.float64]:
        assert waypoints.shape == (1, 2, 2)
        assert body.position.shape == (1, 3)
        self.calls += 1
        return np.array([[[0.0, 5.0], [0.0, 5.0]]])

    def state(self) -> Mapping[str, object]:
        return {"calls": self.calls}


def test_the_policy_observes_the_navigators_goals() -> None:
    messages: list[Message] = []
    navigator = Detour()
    fly(mission_of(AHEAD), Scripted(STILL), messages.append, navigator=navigator)
    seen = [it.values for it in only(Observation, messages)]
    assert navigator.calls == len(seen) > 5
    aside = [it.values for it in only(Observation, flown(mission_of(ASIDE))[1])]
    ahead = [it.values for it in only(Observation, flown(mission_of(AHEAD))[1])]
    assert np.array_equal(seen, aside)
    assert not np.array_equal(seen, ahead)


@pytest.mark.parametrize("goals", [np.zeros((2, 2)), np.full((1, 2, 2), np.nan), None])
def test_goals_that_are_none_are_refused(goals: NDArray[np.float64]) -> None:
    navigator = Detour()
    navigator.goals = lambda body, waypoints: goals  # type: ignore[method-assign]
    with pytest.raises(InputError, match="navigator"):
        fly(mission_of(AHEAD), Scripted(STILL), navigator=navigator)


def test_a_log_names_the_navigator_without_which_it_cannot_be_simulated_again(tmp_path: Path) -> None:
    fly(mission_of(AHEAD), Scripted(STILL), log=tmp_path / "detour.mcap", navigator=Detour())
    found = verify(tmp_path / "detour.mcap")
    assert found.verdict is Verdict.UNVERIFIABLE
    assert "test_navigator.Detour" in found.reason


def test_a_navigators_state_is_in_the_checkpoint_and_one_without_state_adds_nothing() -> None:
    messages: list[Message] = []
    fly(mission_of(AHEAD), Scripted(STILL), messages.append, navigator=Detour())
    assert json.loads(only(Checkpoint, messages)[0].executive)["navigator"] == {"calls": 0}
    assert "navigator" not in json.loads(only(Checkpoint, flown(mission_of(AHEAD))[1])[0].executive)
