"""What a policy sees: the observation layouts, by name.

`state`, `state_noise` and `state_goal` are the paper's: everything in the world frame, unscaled. `egocentric` says
the same in the robot's own yaw frame, so that what is learnt in one direction holds in all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.task.body import JOINT_RATE_SCALE, Body

FloatArray = NDArray[np.float64]

GOAL_RANGE_M: Final = 5.0  # an egocentric goal farther off than this looks as if it were this far
NOISE_SIZE: Final = 4


@dataclass(frozen=True, slots=True)
class Goals:
    """Where n robots are to go.

    Attributes:
        waypoints: (n, 2, 2) the waypoint to walk to and the one after it, which is the same again at the last [m].
        noise: (n, 4) numbers drawn once an episode, for the layout that has them instead of goals.
    """

    waypoints: FloatArray
    noise: FloatArray


@dataclass(frozen=True)
class Layout:
    """An observation layout.

    Attributes:
        name: what recipes and manifests call it.
        components: (name, unit, scale) of each number; an observation is the physical quantity times the scale.
        fill: writes the observation (n, size) of bodies and goals into its first argument.
    """

    name: str
    components: tuple[tuple[str, str, float], ...]
    fill: Callable[[FloatArray, Body, Goals], None]

    @property
    def size(self) -> int:
        """How many numbers an observation has."""
        return len(self.components)

    def observe(self, body: Body, goals: Goals) -> FloatArray:
        """Return the observations (n, size) of n robots."""
        observation = np.empty((len(body.up), self.size))
        self.fill(observation, body, goals)
        return observation


def _fill_state(out: FloatArray, body: Body, goals: Goals) -> None:
    out[:, 0:8] = body.joints
    out[:, 8:16] = body.joint_rates
    out[:, 16:19] = body.position
    out[:, 19:22] = body.velocity
    out[:, 22] = body.roll
    out[:, 23] = body.pitch
    out[:, 24] = body.yaw


def _fill_state_noise(out: FloatArray, body: Body, goals: Goals) -> None:
    _fill_state(out, body, goals)
    out[:, 25:29] = goals.noise


def _fill_state_goal(out: FloatArray, body: Body, goals: Goals) -> None:
    _fill_state(out, body, goals)
    out[:, 25:29] = goals.waypoints.reshape(-1, 4)


def _fill_egocentric(out: FloatArray, body: Body, goals: Goals) -> None:
    cos, sin = np.cos(body.yaw)[:, np.newaxis], np.sin(body.yaw)[:, np.newaxis]
    offset = goals.waypoints - body.position[:, np.newaxis, :2]
    x, y = offset[:, :, 0], offset[:, :, 1]
    distance = np.sqrt(x * x + y * y)
    inverse = 1.0 / np.maximum(distance, 1e-6)
    out[:, 0:6:3] = (cos * x + sin * y) * inverse
    out[:, 1:6:3] = (cos * y - sin * x) * inverse
    out[:, 2:6:3] = np.minimum(distance, GOAL_RANGE_M) * (1.0 / GOAL_RANGE_M)
    vx, vy = body.velocity[:, 0:1], body.velocity[:, 1:2]
    out[:, 6:7] = cos * vx + sin * vy
    out[:, 7:8] = cos * vy - sin * vx
    out[:, 8] = body.velocity[:, 2]
    out[:, 9:12] = body.rates
    out[:, 12] = body.roll
    out[:, 13] = body.pitch
    out[:, 14] = body.position[:, 2]
    out[:, 15:23] = body.joints
    np.multiply(body.joint_rates, JOINT_RATE_SCALE, out=out[:, 23:31])


_JOINTS: Final = tuple(
    f"{leg}_{joint}" for leg in ("front_left", "back_left", "back_right", "front_right") for joint in ("hip", "ankle")
)


def _components(rate_scale: float) -> tuple[tuple[str, str, float], ...]:
    angles = tuple((f"{name}.angle", "rad", 1.0) for name in _JOINTS)
    return angles + tuple((f"{name}.speed", "rad/s", rate_scale) for name in _JOINTS)


def _named(unit: str, *names: str) -> tuple[tuple[str, str, float], ...]:
    return tuple((name, unit, 1.0) for name in names)


_STATE: Final = (
    _components(1.0)
    + _named("m", "torso.x", "torso.y", "torso.z")
    + _named("m/s", "torso.vx", "torso.vy", "torso.vz")
    + _named("rad", "torso.roll", "torso.pitch", "torso.yaw")
)


def _bearing(name: str) -> tuple[tuple[str, str, float], ...]:
    return (*_named("1", f"{name}.ahead", f"{name}.left"), (f"{name}.distance", "m", 1.0 / GOAL_RANGE_M))


_EGOCENTRIC: Final = (
    *_bearing("current"),
    *_bearing("next"),
    *_named("m/s", "torso.v_ahead", "torso.v_left", "torso.v_up"),
    *_named("rad/s", "torso.rate_x", "torso.rate_y", "torso.rate_z"),
    *_named("rad", "torso.roll", "torso.pitch"),
    *_named("m", "torso.z"),
    *_components(JOINT_RATE_SCALE),
)

LAYOUTS: Final = {
    layout.name: layout
    for layout in (
        Layout("state", _STATE, _fill_state),
        Layout("state_noise", _STATE + _named("1", *(f"noise.{i}" for i in range(NOISE_SIZE))), _fill_state_noise),
        Layout("state_goal", _STATE + _named("m", "current.x", "current.y", "next.x", "next.y"), _fill_state_goal),
        Layout("egocentric", _EGOCENTRIC, _fill_egocentric),
    )
}


def layout(name: str) -> Layout:
    """Return the observation layout called `name`.

    Raises:
        InputError: there is none.
    """
    if name not in LAYOUTS:
        raise InputError(f"there is no observation layout called {name!r}; there are: {', '.join(LAYOUTS)}")
    return LAYOUTS[name]
