"""Observation groups and reward terms, the built-in ones and those of a user's own Python file.

A decorated function has an effect only where it is passed. A file is executed only where the user names it. Bundles and
logs record names and hashes of such files, so that another content is refused; nothing is executed because of them.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from traceback import extract_tb
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
    "A group or term of your own needs its Python file: `plugins` in a recipe, with --allow-plugins; --plugin FILE of "
    "`waypointctl run`, `eval` and `replay`; plugins= of fly(), evaluate() and verify() in Python."
)
_NAME: Final = re.compile(r"[a-z][a-z0-9_]{0,59}")
_LARGEST: Final = 2**20  # of a plugin's file [bytes]


@dataclass(frozen=True)
class PluginFile:
    """A Python file that was executed: its name without folders, its content and the hash of that."""

    name: str
    content: bytes = field(repr=False)

    @cached_property
    def sha256(self) -> str:
        """Of the content."""
        return hashlib.sha256(self.content).hexdigest()


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
        source: the file that it was loaded from; None for one that was not loaded from a file.
    """

    name: str
    function: ViewFunction | Fill
    components: Components
    units: str | Sequence[str]
    scales: float | Sequence[float] = 1.0
    built_in: bool = False
    source: PluginFile | None = None

    def filler(self, size: int) -> Fill:
        """Return what writes (n, size) numbers, before the scales."""
        if self.built_in:
            return cast("Fill", self.function)
        return copied(_checked(cast("ViewFunction", self.function), f"observation group {self.name!r}", size))


@dataclass(frozen=True, slots=True)
class RewardTerm:
    """A term of the reward.

    Attributes:
        name: in recipes, manifests and logs.
        function: of a view of n robots after a control period; returns (n,) in the unit.
        unit: of what it returns.
        factor: that multiplies the weight: -1 of a cost.
        built_in: whether it comes with waypointctl; another one's results are checked.
        source: the file that it was loaded from; None for one that was not loaded from a file.
    """

    name: str
    function: ViewFunction
    unit: str
    factor: float = 1.0
    built_in: bool = False
    source: PluginFile | None = None

    def filler(self) -> ViewFunction:
        """Return the function that computes (n,), before the weight."""
        return self.function if self.built_in else _checked(self.function, f"reward term {self.name!r}", 0)


Plugin: TypeAlias = ObservationGroup | RewardTerm
Plugins: TypeAlias = Path | str | Plugin | Iterable[Path | str | Plugin]


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


def load_plugins(plugins: Plugins) -> tuple[Plugin, ...]:
    """Execute Python files and return the observation groups and reward terms that they define.

    Args:
        plugins: the path of a file, or several; a group or a term is returned as it is. A file that is given twice is
            executed once.

    Raises:
        InputError: a file is missing, fails, defines none, or has the name of another one; or an argument has a wrong
            type.
    """
    found: list[Plugin] = []
    hashes: dict[str, str] = {}
    for one in plugins if isinstance(plugins, Iterable) and not isinstance(plugins, str) else (plugins,):
        if isinstance(one, ObservationGroup | RewardTerm):
            found.append(one)
            continue
        if not isinstance(one, Path | str):
            raise wrong_type("plugins", one, "the path of a Python file, a group or a term, or several")
        path = Path(one)
        file = PluginFile(path.name, read_input(path, _LARGEST))
        if hashes.setdefault(file.name, file.sha256) != file.sha256:
            problem = f"two plugins have the file name {file.name}, which logs and policies record"
            raise InputError(problem, where=str(path), hint="rename one of the files")
        if all(plugin.source != file for plugin in found):
            found += _defined(file, path)
    return tuple(found)


def plugin_hashes(plugins: Iterable[Plugin]) -> dict[str, str]:
    """Return the SHA-256 of each file that plugins were loaded from, by its name, in the order of the names."""
    files = {plugin.source.name: plugin.source.sha256 for plugin in plugins if plugin.source is not None}
    return dict(sorted(files.items()))


def named_plugins(hashes: Mapping[str, str]) -> str:
    """Return files and their hashes as a message has them."""
    return ", ".join(f"{name} (SHA-256 {sha256})" for name, sha256 in hashes.items())


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


def _defined(file: PluginFile, path: Path) -> tuple[Plugin, ...]:
    values = vars(_executed(path, file.content)).values()
    own = {id(value): value for value in values if isinstance(value, ObservationGroup | RewardTerm)}
    if not own:
        hint = "decorate a function with @waypointctl.observation_group(...) or @waypointctl.reward_term(...)"
        raise InputError("defines no observation group and no reward term", where=str(path), hint=hint)
    return tuple(replace(value, source=file) for value in own.values())


def _executed(path: Path, source: bytes) -> ModuleType:
    module = ModuleType(f"waypointctl_plugin_{path.stem}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module  # dataclasses look their module up
    try:
        exec(compile(source, str(path), "exec"), vars(module))  # the user has allowed it
    except SyntaxError as error:
        raise InputError(f"is not valid Python: {error.msg}", where=f"{path}:{error.lineno or 1}") from error
    except (Exception, SystemExit) as error:
        lines = [str(at.lineno) for at in extract_tb(error.__traceback__) if at.filename == str(path)]
        raise InputError(f"{type(error).__name__}: {error}", where=":".join([str(path), *lines[-1:]])) from error
    return module


def _sound(name: str) -> str:
    if not _NAME.fullmatch(name):
        raise InputError(f"{name!r} is not a valid name: use lower-case letters, digits, underscores; a letter first")
    return name


def copied(function: ViewFunction) -> Fill:
    """Return what writes the numbers that a function returns, (n, k), into its second argument."""

    def fill(view: SimulationView, out: FloatArray) -> None:
        out[:] = function(view)

    return fill


def _checked(function: ViewFunction, what: str, size: int) -> ViewFunction:
    """Return the function with its result checked, finite numbers (n, size); (n,) for size 0, and allowed for 1."""

    def call(view: SimulationView) -> FloatArray:
        try:
            values = np.asarray(function(view.read_only()), np.float64)
        except Exception as error:
            raise InputError(f"{what} raised {type(error).__name__}: {error}") from error
        n = len(view.body.up)
        if values.shape != ((n, size) if size else (n,)) and not (size == 1 and values.shape == (n,)):
            wanted = f"(n, {size})" if size else "(n,)"
            raise InputError(f"{what} returned the shape {values.shape}, not {wanted} with n = {n}")
        if not np.isfinite(values).all():
            place = np.argwhere(~np.isfinite(values))[0].tolist()
            raise InputError(f"{what} returned {values[tuple(place)]} at {place}, not a finite number")
        return values.reshape(n, size) if size else values

    return call
