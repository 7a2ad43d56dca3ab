"""Observation groups and reward terms, the built-in ones and those of a user's own Python file.

    @waypointctl.reward_term(name="clearance", unit="m")
    def clearance(view):
        return view.foot_heights.min(axis=1)

A decorated function has an effect only where it is passed: in `TaskConfig.plugins`, or in a recipe's `plugins` with the
permission to execute the file. A bundle or a log never names a file to execute.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Final, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from waypointctl.errors import InputError, wrong_type
from waypointctl.input_file import read_input

if TYPE_CHECKING:
    from waypointctl.robots.robot import Robot
    from waypointctl.task.view import SimulationView

FloatArray: TypeAlias = NDArray[np.float64]
ViewFunction: TypeAlias = "Callable[[SimulationView], NDArray[Any]]"
Fill: TypeAlias = "Callable[[SimulationView, FloatArray], None]"  # writes (n, k) into its second argument
Components: TypeAlias = "Sequence[str] | Callable[[Robot], Sequence[str]]"
T = TypeVar("T")

PLUGIN_HINT: Final = (
    "A group or term of your own needs its Python file: `plugins` in a recipe, with --allow-plugins; plugins=[...] "
    "of fly(), evaluate() and verify(path, plugins=[...]) in Python."
)
_NAME: Final = re.compile(r"[a-z][a-z0-9_]{0,59}")
_LARGEST: Final = 2**20  # of a plugin's file [bytes]


@dataclass(frozen=True, slots=True)
class ObservationGroup:
    """Numbers of an observation that belong together.

    Attributes:
        name: in recipes and manifests.
        function: of a view of n robots; returns (n, k), or (n,) for one component, in the unit. That of a built-in
            group writes it into its second argument.
        components: the name of each number, or a function of the robot that returns them.
        units: of each number, or one for all.
        scales: that multiply the numbers, or one for all.
        built_in: whether it comes with waypointctl; the results of others are checked.
        source_sha256: of the file that it was loaded from; empty for one that was not loaded from a file.
    """

    name: str
    function: ViewFunction | Fill
    components: Components
    units: str | Sequence[str]
    scales: float | Sequence[float] = 1.0
    built_in: bool = False
    source_sha256: str = ""

    def named(self, robot: Robot) -> tuple[tuple[str, str, float], ...]:
        """Return (name, unit, scale) of each number for a robot."""
        what = f"observation group {self.name!r}"
        try:
            names = tuple(self.components(robot) if callable(self.components) else self.components)
            units = (self.units,) * len(names) if isinstance(self.units, str) else tuple(self.units)
            scales = np.asarray(self.scales, np.float64)
        except Exception as error:
            raise InputError(f"{what}: {type(error).__name__}: {error}") from error
        if isinstance(self.components, str) or not all(isinstance(text, str) for text in (*names, *units)):
            raise InputError(f"{what}: components and units are lists of texts")
        if not names or len(units) != len(names):
            raise InputError(f"{what}: {len(units)} units for {len(names)} components")
        if scales.shape not in ((), (len(names),)) or not np.isfinite(scales).all():
            raise InputError(
                f"{what}: its scales are not one finite number, or one for each of {len(names)} components"
            )
        return tuple(zip(names, units, np.broadcast_to(scales, len(names)).tolist(), strict=True))

    def filler(self, size: int) -> Fill:
        """Return what writes (n, size) numbers, before the scales."""
        if self.built_in:
            return cast("Fill", self.function)
        shapes = "(n, 1) or (n,)" if size == 1 else f"(n, {size})"
        function = _checked(cast("ViewFunction", self.function), f"observation group {self.name!r}", size, shapes)

        def fill(view: SimulationView, out: FloatArray) -> None:
            values = function(view)
            out[:] = values if values.ndim == 2 else values[:, np.newaxis]

        return fill


@dataclass(frozen=True, slots=True)
class RewardTerm:
    """A term of the reward.

    Attributes:
        name: in recipes, manifests and logs.
        function: of a view of n robots after a control period; returns (n,) in the unit.
        unit: of what it returns.
        factor: that multiplies the weight: -1 of a cost.
        built_in: whether it comes with waypointctl; another one's results are checked.
        source_sha256: of the file that it was loaded from; empty for one that was not loaded from a file.
    """

    name: str
    function: ViewFunction
    unit: str
    factor: float = 1.0
    built_in: bool = False
    source_sha256: str = ""

    def filler(self) -> ViewFunction:
        """Return the function that computes (n,), before the weight."""
        return self.function if self.built_in else _checked(self.function, f"reward term {self.name!r}", 0, "(n,)")


Plugin: TypeAlias = ObservationGroup | RewardTerm


def observation_group(
    *, name: str, unit: str | Sequence[str], components: Components, scale: float | Sequence[float] = 1.0
) -> Callable[[ViewFunction], ObservationGroup]:
    """Make an observation group of a function of a `SimulationView`.

    Args:
        name: in recipes and manifests: lower-case letters, digits and underscores.
        unit: of its numbers, such as "rad/s"; several if they differ.
        components: the name of each number, or a function of the robot that returns them.
        scale: that multiplies the numbers for the network; several if they differ.
    """
    return lambda function: ObservationGroup(_sound(name), function, components, unit, scale)


def reward_term(*, name: str, unit: str) -> Callable[[ViewFunction], RewardTerm]:
    """Make a reward term of a function of a `SimulationView`; the recipe's weight multiplies what it returns.

    Args:
        name: in recipes, manifests and logs: lower-case letters, digits and underscores.
        unit: of what it returns.
    """
    return lambda function: RewardTerm(_sound(name), function, unit)


def load_plugins(paths: Path | str | Iterable[Path | str]) -> tuple[Plugin, ...]:
    """Execute Python files and return the observation groups and reward terms that they define.

    Call it only for files that the user has named and allowed to be executed.

    Args:
        paths: of the files; one path is one file.

    Raises:
        InputError: a file is missing, fails, or defines none; or an argument is not a path.
    """
    if not isinstance(paths, Iterable):
        paths = (paths,)
    found: list[Plugin] = []
    for path in (paths,) if isinstance(paths, str) else paths:
        if not isinstance(path, Path | str):
            raise wrong_type("paths", path, "the path of a Python file, or several")
        source = read_input(Path(path), _LARGEST)
        sha256 = hashlib.sha256(source).hexdigest()
        values = vars(_executed(Path(path), source)).values()
        own = {id(value): value for value in values if isinstance(value, ObservationGroup | RewardTerm)}
        if not own:
            hint = "decorate a function with @waypointctl.observation_group(...) or @waypointctl.reward_term(...)"
            raise InputError("defines no observation group and no reward term", where=str(path), hint=hint)
        found += [replace(value, source_sha256=sha256) for value in own.values()]
    return tuple(found)


def by_name(built_in: Iterable[T], plugins: Iterable[T], what: str) -> dict[str, T]:
    """Return groups or terms by name.

    Raises:
        InputError: two have the same name.
    """
    found: dict[str, T] = {}
    for one in (*built_in, *plugins):
        name = str(getattr(one, "name", ""))
        if name in found:
            raise InputError(f"two {what}s have the name {name!r}", hint="rename the plugin's")
        found[name] = one
    return found


def _executed(path: Path, source: bytes) -> ModuleType:
    module = ModuleType(f"waypointctl_plugin_{path.stem}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module  # dataclasses look their module up
    try:
        exec(compile(source, str(path), "exec"), vars(module))  # the user has allowed it
    except SyntaxError as error:
        line = f":{error.lineno}" if error.lineno else ""
        raise InputError(f"is not valid Python: {error.msg}", where=f"{path}{line}") from error
    except (Exception, SystemExit) as error:
        raise InputError(f"{type(error).__name__}: {error}", where=str(path)) from error
    return module


def _sound(name: str) -> str:
    if not _NAME.fullmatch(name):
        raise InputError(
            f"{name!r} is not a valid name: use lower-case letters, digits and underscores, beginning with a letter"
        )
    return name


def _checked(function: ViewFunction, what: str, size: int, shapes: str) -> ViewFunction:
    """Return the function with its result checked: (n, size) of finite numbers; (n,) where size is 0 or 1."""

    def call(view: SimulationView) -> FloatArray:
        try:
            values = np.asarray(function(view.read_only()), np.float64)
        except Exception as error:
            raise InputError(f"{what} raised {type(error).__name__}: {error}") from error
        n = len(view.body.up)
        if values.shape != ((n, size) if size else (n,)) and not (size == 1 and values.shape == (n,)):
            raise InputError(f"{what} returned the shape {values.shape}, not {shapes} with n = {n}")
        if not np.isfinite(values).all():
            place = np.argwhere(~np.isfinite(values))[0].tolist()
            raise InputError(f"{what} returned {values[tuple(place)]} at {place}, not a finite number")
        return values

    return call
