"""A robot out of its robot.yaml and its compiled MJCF: each name in the one is looked up in the other."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import RobotError
from waypointctl.mission.problems import Problem
from waypointctl.mission.yaml_source import as_error, written_at
from waypointctl.mission.yaml_tree import DataPath, read_tree
from waypointctl.robots.description import (
    ROBOT_FILE,
    ActionGroup,
    PositionTarget,
    RobotDescription,
    TorqueFraction,
    VelocityTarget,
)
from waypointctl.robots.robot import Robot, Symmetry, combined, frame_of
from waypointctl.sim.actions import ActionTransform
from waypointctl.sim.mjcf_audit import AuditedMjcf
from waypointctl.sim.model import CameraMount, actuators_of, joint_names_of, joint_range_of, missing_geoms

FloatArray = NDArray[np.float64]

_SERVOS: Final = {TorqueFraction: "motor", PositionTarget: "position", VelocityTarget: "velocity"}
_NAMED: Final = 20  # joints in a message
_RANGE_TOLERANCE_RAD: Final = 1e-6


def build_robot(description: RobotDescription, source: bytes, mjcf: AuditedMjcf, model: Any, where: str) -> Robot:
    """Return a robot.

    Args:
        description: robot.yaml.
        source: its text.
        mjcf: the MJCF.
        model: what that compiles to, a MuJoCo model.
        where: robot.yaml's name, for messages.

    Raises:
        RobotError: robot.yaml does not fit the MJCF; everything wrong is listed with line and column.
    """
    builder = _Builder(description, model)
    if builder.problems:
        tree = read_tree(source)
        places = [(*written_at(tree, path), text) for path, text in builder.problems]
        problems = [Problem(where, mark.line, mark.column, written, text) for written, mark, text in places]
        raise as_error(tuple(sorted(problems, key=lambda each: (each.line, each.column))), RobotError)
    return Robot(
        name=description.name,
        source=mjcf,
        model=model,
        substeps=description.substeps,
        actions=builder.transform,
        camera=CameraMount(description.camera.position_m, description.camera.pitch_deg),
        description=description,
        files={ROBOT_FILE: source, **mjcf.files},
        nominal=builder.nominal,
        is_servo=builder.is_servo,
        servo_rest=builder.servo_rest,
        symmetries=builder.symmetries,
    )


class _Builder:
    """Looks up names and works out numbers; what is wrong is collected, each with its path in robot.yaml."""

    def __init__(self, description: RobotDescription, model: Any) -> None:
        self.problems: list[tuple[DataPath, str]] = []
        self._description = description
        self._names = joint_names_of(model)
        self._index = {name: index for index, name in enumerate(self._names)}
        self._low, self._high = joint_range_of(model)
        self._actuators = actuators_of(model)
        self.nominal = self._nominal()
        size = len(self._actuators.joints)
        self.is_servo: NDArray[np.bool_] = np.zeros(size, bool)
        self.servo_rest: FloatArray = np.zeros(size)
        self.transform = ActionTransform(np.ones(size), np.zeros(size), np.full(size, -np.inf), np.full(size, np.inf))
        self._fill_actions()
        for number in missing_geoms(model, description.feet):
            self.problems.append((("feet", number), f"there is no geom {description.feet[number]!r}"))
        self.symmetries = self._symmetries()
        if description.termination.min_height_m >= description.nominal.height_m:
            text = f"a robot at its nominal height of {description.nominal.height_m:g} m has fallen"
            self.problems.append((("termination", "min_height_m"), text))

    def _nominal(self) -> FloatArray:
        degrees = np.zeros(len(self._names))
        for name, angle_deg in self._description.nominal.joints_deg.items():
            if name not in self._index:
                self.problems.append((("nominal", "joints_deg", name), self._no_joint(name)))
                continue
            degrees[self._index[name]] = angle_deg
        nominal: FloatArray = np.deg2rad(degrees)
        tolerance = _RANGE_TOLERANCE_RAD
        outside = (nominal < self._low - tolerance) | (nominal > self._high + tolerance)
        for index in np.flatnonzero(outside).tolist():
            low, high = np.rad2deg([self._low[index], self._high[index]]).tolist()
            name = self._names[index]
            text = (
                f"the nominal angle of {name} is {degrees[index]:g} deg, outside its range of {low:g} to {high:g} deg"
            )
            self.problems.append((("nominal", "joints_deg", name), text))
        return nominal

    def _fill_actions(self) -> None:
        """Give each actuator the numbers of its group."""
        groups: dict[int, int] = {}
        for number, group in enumerate(self._description.actions):
            for place, pattern in enumerate(group.joints):
                matched = [i for i, name in enumerate(self._actuators.joints) if fnmatchcase(name, pattern)]
                if not matched:
                    text = f"no actuator drives {pattern!r}; those that are driven: {_listed(self._actuators.joints)}"
                    self.problems.append((("actions", number, "joints", place), text))
                for actuator in matched:
                    if groups.setdefault(actuator, number) != number:
                        text = f"{self._actuators.joints[actuator]} belongs to actions[{groups[actuator]}] already"
                        self.problems.append((("actions", number, "joints", place), text))
        for actuator, number in sorted(groups.items()):
            if fault := self._fill_action(actuator, self._description.actions[number]):
                self.problems.append((("actions", number, "kind"), fault))
        if missing := [name for i, name in enumerate(self._actuators.joints) if i not in groups]:
            self.problems.append((("actions",), f"no entry covers {_listed(missing)}"))

    def _fill_action(self, actuator: int, group: ActionGroup) -> str:
        """Return why a group cannot be that of an actuator, nothing where it is filled in."""
        name, servo = self._actuators.joints[actuator], self._actuators.servos[actuator]
        low, high = float(self._actuators.low[actuator]), float(self._actuators.high[actuator])
        joint = self._index[name]
        if servo != _SERVOS[type(group)]:
            return f"{group.kind} needs a {_SERVOS[type(group)]} actuator; {name} has a {servo} actuator"
        nominal = float(self.nominal[joint])
        match group:
            case TorqueFraction():
                if not (np.isfinite(high) and high > 0 and low == -high):
                    return f"the MJCF's ctrlrange of {name} has to be -full to full"
                scale, offset, rest = high, 0.0, 0.0
            case PositionTarget():
                scale = float(np.deg2rad(group.scale_deg))
                offset = nominal if group.offset_deg is None else float(np.deg2rad(group.offset_deg))
                limits = group.limits_deg and np.deg2rad(group.limits_deg).tolist()
                rest = (nominal - offset) / scale
                own = limits or (float(self._low[joint]), float(self._high[joint]))
                low, high = max(low, own[0]), min(high, own[1])
            case VelocityTarget():
                scale, offset, rest = group.scale_radps, group.offset_radps, -group.offset_radps / group.scale_radps
                own = group.limits_radps or (-np.inf, np.inf)
                low, high = max(low, own[0]), min(high, own[1])
        if not low < high:
            return f"no target of {name} is within all limits: {low:g} is not below {high:g}"
        if abs(rest) > 1:
            return f"no action within -1 to 1 holds {name} at rest: it would be {rest:g}"
        numbers = self.transform
        numbers.scale[actuator], numbers.offset[actuator] = scale, offset
        numbers.low[actuator], numbers.high[actuator] = low, high
        self.is_servo[actuator], self.servo_rest[actuator] = servo != "motor", rest
        return ""

    def _symmetries(self) -> tuple[Symmetry, ...]:
        given = []
        for name, entry in self._description.symmetries.items():
            images = {before: after.removeprefix("-") for before, after in entry.joints.items()}
            if fault := self._image_fault(images):
                self.problems.append((("symmetries", name, "joints"), fault))
                continue
            sources: NDArray[np.intp] = np.zeros(len(self._names), np.intp)
            signs = np.ones(len(self._names))
            for before, after in entry.joints.items():
                image = self._index[after.removeprefix("-")]
                sources[image], signs[image] = self._index[before], -1.0 if after.startswith("-") else 1.0
            symmetry = Symmetry(name, frame_of(entry.mirror, entry.turn_deg), sources, signs)
            if fault := self._range_fault(symmetry):
                self.problems.append((("symmetries", name, "joints"), fault))
            given.append(symmetry)
        try:
            return combined(given, len(self._names))
        except ValueError as error:
            self.problems.append((("symmetries",), str(error)))
            return ()

    def _image_fault(self, images: dict[str, str]) -> str:
        """Return why joints cannot become each other, nothing if they can."""
        if unknown := [name for name in (*images, *images.values()) if name not in self._index]:
            return self._no_joint(unknown[0])
        if missing := set(self._names) - set(images):
            return f"has no image for {_listed(sorted(missing))}"
        if twice := [name for name in images.values() if list(images.values()).count(name) > 1]:
            return f"two joints map to {twice[0]}"
        driven = set(self._actuators.joints)
        if mixed := [name for name, image in images.items() if (name in driven) != (image in driven)]:
            return f"{mixed[0]} and {images[mixed[0]]} do not both have an actuator"
        return ""

    def _range_fault(self, symmetry: Symmetry) -> str:
        """Return which joint and its image have other ranges or nominal angles, nothing if all agree."""
        low, high = self._low[symmetry.joints], self._high[symmetry.joints]
        flipped = symmetry.signs < 0
        ranges = np.where(flipped, -high, low), np.where(flipped, -low, high)
        pairs = ((ranges[0], self._low), (ranges[1], self._high))
        agree = np.isclose(self.nominal[symmetry.joints] * symmetry.signs, self.nominal)
        for image, own in pairs:
            agree &= np.isclose(image, own)
        other = np.flatnonzero(~agree)
        if not len(other):
            return ""
        joint = int(other[0])
        return f"{self._names[symmetry.joints[joint]]} and {self._names[joint]} differ in range or nominal angle"

    def _no_joint(self, name: str) -> str:
        return f"there is no joint {name!r}; there are: {_listed(self._names)}"


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f"{', '.join(names[:_NAMED])}{more}"
