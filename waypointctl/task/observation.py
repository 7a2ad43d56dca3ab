"""Observation groups and the layouts made of them.

`state`, `state_noise` and `state_goal` are the paper's: everything in the world frame, unscaled. `egocentric` is the
same in the robot's own yaw frame, so a policy's behaviour does not depend on the direction.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError
from waypointctl.task.plugins import PLUGIN_HINT, Fill, ObservationGroup, Plugin, by_name, copied
from waypointctl.task.view import JOINT_RATE_SCALE, SimulationView, write_heading_velocity

if TYPE_CHECKING:
    from waypointctl.robots.load import RobotOutline
    from waypointctl.robots.robot import Robot

FloatArray: TypeAlias = NDArray[np.float64]

GOAL_RANGE_M: Final = 5.0  # the distance of a goal is at most this in `waypoint_bearings`
NOISE_SIZE: Final = 4
CUSTOM: Final = "custom"  # what manifests call a layout that is a recipe's own list of groups


@dataclass(frozen=True)
class Layout:
    """An observation layout for a robot.

    Attributes:
        name: its name in recipes and manifests; CUSTOM for a list of groups.
        groups: the names of its groups, in order.
        components: (name, unit, scale) of each number; an observation is the physical quantity times the scale.
        fillers: of each group: where its numbers are, what writes them, and its scales where they are not all 1.
    """

    name: str
    groups: tuple[str, ...]
    components: tuple[tuple[str, str, float], ...]
    fillers: tuple[tuple[slice, Fill, FloatArray | None], ...]

    @property
    def size(self) -> int:
        """How many numbers an observation has."""
        return len(self.components)

    def observe(self, view: SimulationView) -> FloatArray:
        """Return the observations (n, size) of n robots."""
        observation = np.empty((len(view.body.up), self.size))
        for place, fill, scales in self.fillers:
            part = observation[:, place]
            fill(view, part)
            if scales is not None:
                part *= scales
        return observation


def _angles(robot: Robot) -> Sequence[str]:
    return [f"{name}.angle" for name in robot.joint_names]


def _speeds(robot: Robot) -> Sequence[str]:
    return [f"{name}.speed" for name in robot.joint_names]


def _actions(robot: Robot) -> Sequence[str]:
    return [f"{robot.joint_names[joint]}.action" for joint in robot.actuated]


def _base(*parts: str) -> Callable[[Robot], Sequence[str]]:
    """Return what names parts of the base's state after the robot's base."""
    return lambda robot: [f"{robot.base}.{part}" for part in parts]


def _feet(robot: Robot) -> Sequence[str]:
    return [f"{name}.contact" for name in robot.feet]


def _orientation(view: SimulationView, out: FloatArray) -> None:
    _roll_pitch(view, out)
    out[:, 2] = view.body.yaw


def _roll_pitch(view: SimulationView, out: FloatArray) -> None:
    out[:, 0] = view.body.roll
    out[:, 1] = view.body.pitch


def _heading_velocity(view: SimulationView, out: FloatArray) -> None:
    write_heading_velocity(view.body, out)


def _waypoint_bearings(view: SimulationView, out: FloatArray) -> None:
    """Write the direction and the distance of both goals in the yaw frame, (n, 6): ahead, left, distance [m]."""
    body = view.body
    cos, sin = np.cos(body.yaw)[:, np.newaxis], np.sin(body.yaw)[:, np.newaxis]
    offset = view.goals - body.position[:, np.newaxis, :2]
    x, y = offset[:, :, 0], offset[:, :, 1]
    distance = np.sqrt(x * x + y * y)
    inverse = 1.0 / np.maximum(distance, 1e-6)
    out[:, 0::3] = (cos * x + sin * y) * inverse
    out[:, 1::3] = (cos * y - sin * x) * inverse
    out[:, 2::3] = np.minimum(distance, GOAL_RANGE_M)


def _group(
    name: str,
    units: str | Sequence[str],
    components: Any,
    fill: Fill,
    scales: float | Sequence[float] = 1.0,
) -> ObservationGroup:
    return ObservationGroup(name, fill, components, units, scales, built_in=True)


_PART: Final = 1.0 / GOAL_RANGE_M
_BEARINGS: Final = [f"{goal}.{part}" for goal in ("current", "next") for part in ("ahead", "left", "distance")]
_GOALS: Final = ("current.x", "current.y", "next.x", "next.y")
_NOISE: Final = tuple(f"noise.{number}" for number in range(NOISE_SIZE))

GROUPS: Final = (
    _group("joint_angles", "rad", _angles, copied(lambda view: view.body.joints)),
    _group("joint_speeds", "rad/s", _speeds, copied(lambda view: view.body.joint_rates)),
    _group("joint_speeds_scaled", "rad/s", _speeds, copied(lambda view: view.body.joint_rates), JOINT_RATE_SCALE),
    _group("position", "m", _base("x", "y", "z"), copied(lambda view: view.body.position)),
    _group("height", "m", _base("z"), copied(lambda view: view.body.position[:, 2:3])),
    _group("velocity", "m/s", _base("vx", "vy", "vz"), copied(lambda view: view.body.velocity)),
    _group(
        "heading_velocity",
        "m/s",
        _base("v_ahead", "v_left", "v_up"),
        _heading_velocity,
    ),
    _group("orientation", "rad", _base("roll", "pitch", "yaw"), _orientation),
    _group("roll_pitch", "rad", _base("roll", "pitch"), _roll_pitch),
    _group(
        "angular_velocity",
        "rad/s",
        _base("rate_x", "rate_y", "rate_z"),
        copied(lambda view: view.body.rates),
    ),
    _group("waypoints", "m", _GOALS, copied(lambda view: view.goals.reshape(-1, 4))),
    _group("waypoint_bearings", ("1", "1", "m") * 2, _BEARINGS, _waypoint_bearings, (1.0, 1.0, _PART) * 2),
    _group("noise", "1", _NOISE, copied(lambda view: view.noise)),
    _group("last_action", "1", _actions, copied(lambda view: view.action)),
    _group("contacts", "1", _feet, copied(lambda view: view.contacts)),
)

_STATE: Final = ("joint_angles", "joint_speeds", "position", "velocity", "orientation")
LAYOUTS: Final[dict[str, tuple[str, ...]]] = {
    "state": _STATE,
    "state_noise": (*_STATE, "noise"),
    "state_goal": (*_STATE, "waypoints"),
    "egocentric": (
        "waypoint_bearings",
        "heading_velocity",
        "angular_velocity",
        "roll_pitch",
        "height",
        "joint_angles",
        "joint_speeds_scaled",
    ),
}


def groups_of(observation: str | Sequence[str], plugins: Iterable[Plugin] = ()) -> tuple[ObservationGroup, ...]:
    """Return the groups of a layout, by its name or theirs.

    Raises:
        InputError: a layout or group is unknown, or a group is listed twice.
    """
    if isinstance(observation, str) and observation not in LAYOUTS:
        raise InputError(f"unknown observation layout {observation!r}; available: {', '.join(LAYOUTS)}")
    names = LAYOUTS[observation] if isinstance(observation, str) else tuple(observation)
    groups = _known(plugins)
    if unknown := [name for name in names if name not in groups]:
        problem = f"unknown observation group {unknown[0]!r}; available: {', '.join(groups)}"
        raise InputError(problem, hint=PLUGIN_HINT)
    if not names or len(set(names)) < len(names):
        raise InputError(f"an observation needs at least one group, and each group once; got {list(names)}")
    return tuple(groups[name] for name in names)


def unknown_groups(names: Sequence[str], plugins: Iterable[Plugin] = ()) -> list[str]:
    """Return the names that are neither a built-in group nor one of the plugins."""
    groups = _known(plugins)
    return [name for name in names if name not in groups]


def _known(plugins: Iterable[Plugin]) -> dict[str, ObservationGroup]:
    given = (plugin for plugin in plugins if isinstance(plugin, ObservationGroup))
    return by_name(GROUPS, given, "observation group")


def layout(observation: str | Sequence[str], robot: Robot | RobotOutline, plugins: Iterable[Plugin] = ()) -> Layout:
    """Return an observation layout for a robot.

    Args:
        observation: a layout's name, or the names of groups.
        robot: that observes.
        plugins: that groups may come from, besides the built-in ones.

    Raises:
        InputError: a layout or group is unknown, or a group is listed twice.
    """
    groups = groups_of(observation, plugins)
    names = tuple(group.name for group in groups)
    named = next((name for name, own in LAYOUTS.items() if own == names), CUSTOM)
    components: list[tuple[str, str, float]] = []
    fillers = []
    for group in groups:
        parts = components_of(group, robot)
        scales = np.array([scale for _, _, scale in parts])
        place = slice(len(components), len(components) + len(parts))
        fillers.append((place, group.filler(len(parts)), None if (scales == 1.0).all() else scales))
        components += parts
    return Layout(named, names, tuple(components), tuple(fillers))


def components_of(group: ObservationGroup, robot: Robot | RobotOutline) -> tuple[tuple[str, str, float], ...]:
    """Return (name, unit, scale) of each number of a group for a robot."""
    what = f"observation group {group.name!r}"
    try:
        names = tuple(group.components(cast("Robot", robot)) if callable(group.components) else group.components)
        units = (group.units,) * len(names) if isinstance(group.units, str) else tuple(group.units)
        scales = np.asarray(group.scales, np.float64)
    except Exception as error:
        raise InputError(f"{what}: {type(error).__name__}: {error}") from error
    if isinstance(group.components, str) or not all(isinstance(text, str) for text in (*names, *units)):
        raise InputError(f"{what}: components and units are lists of texts")
    if not names or len(units) != len(names):
        raise InputError(f"{what}: {len(units)} units for {len(names)} components")
    if scales.shape not in ((), (len(names),)) or not np.isfinite(scales).all():
        raise InputError(f"{what}: its scales are not one finite number, or one for each of {len(names)}")
    return tuple(zip(names, units, np.broadcast_to(scales, len(names)).tolist(), strict=True))
