from __future__ import annotations

import numpy as np
import pytest

from tests.flight.flying import flown, mission_of, only
from tests.policy.recurrent import Recurrent
from waypointctl.evaluation.rollout import rollout
from waypointctl.log.messages import Action, Checkpoint, Observation
from waypointctl.log.topics import BY_KIND
from waypointctl.policy.protocol import Policy, state_from, state_text
from waypointctl.seeding import stream
from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.task.config import TaskConfig


def test_a_state_survives_its_text_bit_for_bit() -> None:
    state = {
        "cell": np.array([[0.1, -0.0, np.nan, np.inf]], np.float32),
        "big": np.arange(6, dtype=">f8").reshape(2, 3),
        "count": np.array([7], np.int64),
        "none": np.zeros((1, 0)),
        "flag": np.array(True),
    }
    found = state_from(state_text(state))
    assert list(found) == list(state)
    for name, array in state.items():
        assert found[name].shape == array.shape
        assert found[name].tobytes() == array.astype(array.dtype.newbyteorder("<")).tobytes()
    assert state_text({}) == ""
    assert state_from("") == {}


@pytest.mark.parametrize(
    "text",
    ["{", "3", '{"a": 1}', '{"a": ["|O", [1], ""]}', '{"a": ["<f8", [2], "AAAAAAAAAAA="]}', '{"a": ["?!", [], ""]}'],
)
def test_what_is_no_state_is_refused(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 json's and numpy's own among them
        state_from(text)


def test_a_checkpoint_holds_what_the_next_actions_depend_on() -> None:
    _, messages = flown(mission_of({"position_m": [30.0, 0.0], "timeout_s": 12.0}), Recurrent())
    middle = next(message for message in only(Checkpoint, messages) if message.step > 0)
    topic = BY_KIND[Checkpoint]
    decoded = topic.decode(topic.encode(middle))
    assert isinstance(decoded, Checkpoint)
    policy = Recurrent()
    policy.restore(state_from(decoded.policy_state))
    actions = {action.step: action for action in only(Action, messages)}
    later = [seen for seen in only(Observation, messages) if seen.step >= decoded.step]
    assert len(later) > 20
    for seen in later:
        assert policy.act(seen.values[np.newaxis])[0].tobytes() == actions[seen.step].commanded.tobytes()


def test_flights_begin_with_a_new_episode() -> None:
    mission, policy = mission_of({"position_m": [3.0, 0.0], "timeout_s": 1.0}), Recurrent()
    first, again = (only(Action, flown(mission, policy)[1]) for _ in range(2))
    assert [action.commanded.tobytes() for action in first] == [action.commanded.tobytes() for action in again]


def test_each_robot_of_a_rollout_keeps_its_own_state() -> None:
    paths = [np.array([[0.4 + 0.4 * i, 0.1]]) for i in range(4)]  # they end at different times

    def rolled_out(trials: list[int], policy: Policy) -> list[tuple[float, float]]:
        env = BatchedWaypointEnv(TaskConfig(), len(trials), 0, threads=1, max_waypoints=1, autoreset=False)
        env.starts = [stream(0, "start", i) for i in trials]
        found = rollout(env, policy, [paths[i] for i in trials], lambda ended: None)
        return list(zip(found.time_s.tolist(), found.path_m.tolist(), strict=True))

    policy = Recurrent()
    together = rolled_out([0, 1, 2, 3], policy)
    assert len(set(together)) == 4
    assert together == [rolled_out([i], policy)[0] for i in range(4)]
