"""The batched env with stable-baselines3's interface: all robots in one call."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvObs, VecEnvStepReturn

from waypointctl.task.batched import BatchedWaypointEnv
from waypointctl.training.learner import Rollout


class BatchedVecEnv(VecEnv):
    """A BatchedWaypointEnv with stable-baselines3's interface.

    Observations are float32, rewards are scaled. An episode cut short by its deadline or by success is marked as
    truncated, so that PPO adds the value of where it stood.
    """

    def __init__(self, env: BatchedWaypointEnv, reward_scale: float) -> None:
        """Wrap `env`; every reward is multiplied by `reward_scale`."""
        bound = np.full(env.layout.size, np.inf, np.float32)
        limit = np.ones(env.robot.num_actions, np.float32)
        super().__init__(env.num_robots, spaces.Box(-bound, bound), spaces.Box(-limit, limit))
        self.env = env
        self._rollout = Rollout()
        self._reward_scale = reward_scale
        self._actions: NDArray[np.float64] = np.zeros((env.num_robots, env.robot.num_actions))

    def drain(self) -> Rollout:
        """Return what was counted since the last call, and begin anew."""
        rollout, self._rollout = self._rollout, Rollout()
        return rollout

    def reset(self) -> VecEnvObs:
        """Begin a new episode with every robot."""
        return self.env.reset().astype(np.float32)

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Keep the actions (n, nu) for `step_wait`."""
        self._actions = actions.astype(np.float64)

    def step_wait(self) -> VecEnvStepReturn:
        """Step all robots."""
        step = self.env.step(self._actions)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for i, final in zip(step.ended, step.final_observation.astype(np.float32), strict=True):
            infos[i] = {"terminal_observation": final, "TimeLimit.truncated": bool(step.truncated[i])}
            infos[i]["is_success"] = bool(step.success[i])
        self._rollout.add(step)
        return (
            step.observation.astype(np.float32),
            (self._reward_scale * step.reward).astype(np.float32),
            step.terminated | step.truncated,
            infos,
        )

    def close(self) -> None:
        """Nothing to release: the physics threads end with the object."""

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return an attribute of this object, once for each of the robots."""
        if attr_name == "render_mode":
            return [None for _ in self._get_indices(indices)]
        return [getattr(self, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Refuse: the robots share one env."""
        raise AttributeError(f"the robots of a batch share one env; {attr_name} cannot be set for some of them")

    def env_method(self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any) -> list[Any]:
        """Refuse: the robots share one env."""
        raise AttributeError(f"the robots of a batch share one env; call {method_name} on BatchedVecEnv.env")

    def env_is_wrapped(self, wrapper_class: type, indices: VecEnvIndices = None) -> list[bool]:
        """No robot has a wrapper of its own."""
        return [False for _ in self._get_indices(indices)]

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Leave the seeds alone: the batched env was given its own when it was made."""
        return [None] * self.num_envs
