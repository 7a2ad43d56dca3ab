"""What a flight needs of its policy: that it fits the robot, its reward weights, and what the log says of it.

The simulator is not loaded here, so that `validate` need not wait for it.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

from waypointctl.errors import InputError, LogError, PolicyError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import ActionSpec, Manifest, ObservationSpec
from waypointctl.policy.manifest_file import other_policy_hint
from waypointctl.policy.protocol import Policy
from waypointctl.robots.load import RobotOutline
from waypointctl.sim.actions import refuse_bad_action
from waypointctl.task.observation import LAYOUTS, groups_of, layout, unknown_groups
from waypointctl.task.plugins import PLUGIN_HINT, Plugin, RewardTerm, named_plugins, plugin_hashes
from waypointctl.task.reward import RewardWeights
from waypointctl.units import NS_PER_S

if TYPE_CHECKING:
    from waypointctl.robots.robot import Robot

FloatArray: TypeAlias = NDArray[np.float64]

POLICY_CLASS: Final = "policy_class"  # of a policy that is not a bundle: the log does not carry it
REWARD_WEIGHTS: Final = "reward_weights"  # of such a policy, JSON
PLUGIN_HASH: Final = "sha256_plugin/"  # of each file of groups and terms of the user's: the log does not carry it
PLUGINS_NOT_OF_A_FILE: Final = "plugins_not_of_a_file"  # names of other groups and terms of the user's
GIVE_PLUGINS: Final = "give the file with --plugin FILE, or with plugins= in Python"
LIMITS: Final = (-1.0, 1.0)  # of an action
_NS_PER_MS: Final = NS_PER_S // 1000
_WEIGHTS: Final = TypeAdapter(dict[str, float])


class PolicyNotInLog(Policy):
    """A policy that a log names and does not carry: its class, and what a replay needs besides its actions."""

    def __init__(self, metadata: Mapping[str, str], robot: Robot) -> None:
        """Read from a log's header which policy drove `robot`.

        Raises:
            LogError: its reward weights are not a mapping of names to numbers.
        """
        self.class_name = metadata.get(POLICY_CLASS, "")
        self._metadata = metadata
        self._robot = robot
        try:
            self._weights = _WEIGHTS.validate_json(metadata.get(REWARD_WEIGHTS, ""))
        except ValidationError as error:
            raise LogError(f"metadata: {REWARD_WEIGHTS}: expected a mapping of names to numbers") from error

    @property
    def name(self) -> str:
        """What the log calls it."""
        return self._metadata.get("policy", "")

    @property
    def robot(self) -> str:
        """The robot that it drove."""
        return self._robot.name

    @property
    def observation_layout(self) -> str | tuple[str, ...]:
        """Its observation layout."""
        text = self._metadata.get("observation_layout", "")
        return text if text in LAYOUTS else tuple(text.split())

    @property
    def reward_weights(self) -> Mapping[str, float]:
        """The weight of each reward term."""
        return self._weights

    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return zeros: its actions are not known."""
        return np.zeros((len(observation), self._robot.num_actions))


def refuse_misfit(policy: Policy | Manifest, robot: Robot | RobotOutline, plugins: Sequence[Plugin] = ()) -> None:
    """Refuse a policy that was not made for a robot.

    Args:
        policy: that is to fly; of one in a folder its manifest is enough.
        robot: that it is to drive.
        plugins: that are given.

    Raises:
        PolicyError: it was made for another robot, observation layout, control period or kind of action, there is no
            such observation layout or group, or it was trained with a plugin of another content.
    """
    manifest = policy.manifest if isinstance(policy, LoadedPolicy) else policy
    trained_with = manifest.plugins if isinstance(manifest, Manifest) else {}
    try:
        components = layout(policy.observation_layout, robot, plugins).components
    except InputError as error:
        problem, hint = error.problem, error.hint
        if trained_with and hint == PLUGIN_HINT:
            missing = ", ".join(map(repr, unknown_groups(policy.observation_layout, plugins)))
            problem = f"the policy observes {missing} of the plugin {named_plugins(trained_with)}"
            hint = f"give {'it' if len(trained_with) == 1 else 'them'} with --plugin, or with plugins= in Python"
        raise PolicyError(problem, where=f"policy {policy.name!r}", hint=hint) from error
    refuse_other_robot(policy, robot.name)
    if isinstance(manifest, Manifest):
        _refuse_other_plugins(manifest, plugins)
        _refuse_other_sizes(manifest, robot, components)


def refuse_other_robot(policy: Policy | Manifest, robot: str) -> None:
    """Refuse a policy that was made for another robot.

    Raises:
        PolicyError: it was.
    """
    if policy.robot != robot:
        problem = f"made for the robot {policy.robot!r}, not {robot!r}"
        raise PolicyError(problem, where=f"policy {policy.name!r}", hint=other_policy_hint(robot))


def _refuse_other_sizes(
    manifest: Manifest, robot: Robot | RobotOutline, components: Sequence[tuple[str, str, float]]
) -> None:
    """Refuse a policy for other observations, actions or another control period.

    Args:
        manifest: of the policy.
        robot: each of its motors takes an action in [-1, 1].
        components: (name, unit, scale) of each number of the observation, in order.
    """
    where = f"policy {manifest.name!r}"
    if fault := _layout_fault(manifest.observation, components):
        problem = f"made for another observation layout {manifest.observation.layout!r}: {fault}"
        raise PolicyError(problem, where=where, hint="train a policy with this version of the layout")
    if fault := _action_fault(manifest.action, robot.num_actions):
        hint = f"train a policy for {robot.name!r} as it is"
        raise PolicyError(f"made for other actions: {fault}", where=where, hint=hint)
    if manifest.control_period_ns != robot.control_period_ns:
        problem = f"made for a control period of {_ms(manifest.control_period_ns)}, not {_ms(robot.control_period_ns)}"
        raise PolicyError(problem, where=where, hint="use a policy trained at the robot's control period")


def _layout_fault(made_for: ObservationSpec, given: Sequence[tuple[str, str, float]]) -> str:
    if made_for.size != len(given):
        return f"it has {made_for.size} numbers, not {len(given)}"
    expected = zip(made_for.names, made_for.units, made_for.scales, strict=True)
    for index, (expected_number, found_number) in enumerate(zip(expected, given, strict=True)):
        for what, of, there in zip(("", "unit of ", "scale of "), expected_number, found_number, strict=True):
            if of != there:
                return f"{what}number {index} is {of!r}, not {there!r}"
    return ""


def _action_fault(made_for: ActionSpec, num_actions: int) -> str:
    if made_for.size != num_actions:
        return f"it has {made_for.size}, and the robot has {num_actions} actuators"
    if made_for.limits != LIMITS:
        return f"within {list(made_for.limits)}, not {list(LIMITS)}"
    return ""


def _ms(time_ns: int) -> str:
    return f"{time_ns / _NS_PER_MS:g} ms"


def _refuse_other_plugins(manifest: Manifest, plugins: Sequence[Plugin]) -> None:
    """Refuse a group or term of another file than the policy was trained with."""
    if not manifest.plugins:
        return
    for one in plugins_used(manifest.observation_layout, manifest.reward, plugins):
        if one.source is None or one.source.sha256 not in manifest.plugins.values():
            given = named_plugins(plugin_hashes([one])) or "no file"
            problem = f"{one.name!r} is from {given}; the policy was trained with {named_plugins(manifest.plugins)}"
            raise PolicyError(problem, where=f"policy {manifest.name!r}", hint="give the file that it was trained with")


def plugins_used(
    observation: str | Sequence[str], weighed: Iterable[str], plugins: Sequence[Plugin]
) -> tuple[Plugin, ...]:
    """Return those of the given plugins that are observed, or weighed in the reward.

    Raises:
        InputError: as for `groups_of`.
    """
    terms, groups = set(weighed), {group.name for group in groups_of(observation, plugins)}
    return tuple(one for one in plugins if one.name in (terms if isinstance(one, RewardTerm) else groups))


def chosen_action(policy: Policy, observation: FloatArray, num_actions: int) -> FloatArray:
    """Return the policy's action (1, nu) for an observation (1, k).

    Raises:
        PolicyError: it is not numbers, has another shape, or a number that is not finite.
    """
    action = policy.act(observation)
    if isinstance(policy, LoadedPolicy):
        return action  # checked when it was loaded, and by the network
    try:
        return refuse_bad_action(action, num_actions, 1)
    except InputError as error:
        raise PolicyError(error.problem, where=f"policy {policy.name!r}", hint=error.hint) from error


def reward_weights(policy: Policy, plugins: Iterable[Plugin] = ()) -> RewardWeights:
    """Return the weight of each reward term, those that the policy does not name at their defaults.

    The terms of a plugin that is not given are left out: they change the rewards in the log, not the flight.

    Raises:
        PolicyError: a weight is not a number within its bounds.
    """
    known = {*RewardWeights.model_fields, *(one.name for one in plugins if isinstance(one, RewardTerm))}
    own = {name: weight for name, weight in policy.reward_weights.items() if name in known}
    try:
        return RewardWeights.model_validate(own)
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        problem = f"reward.{'.'.join(map(str, fault['loc']))}: {fault['msg']}"
        raise PolicyError(problem, where="policy", hint="train the policy again") from error


def policy_facts(policy: Policy) -> dict[str, str]:
    """Return the hash of a bundle; of another policy its class, and what replay needs of it besides its actions."""
    if isinstance(policy, LoadedPolicy):
        return {"sha256_policy": policy.sha256}
    name = policy.class_name if isinstance(policy, PolicyNotInLog) else class_name(policy)
    return {POLICY_CLASS: name, REWARD_WEIGHTS: json.dumps(dict(policy.reward_weights))}


def plugin_facts(policy: Policy, plugins: Sequence[Plugin]) -> dict[str, str]:
    """Return what a flight uses that is neither built in nor in the log; nothing for most flights."""
    used = plugins_used(policy.observation_layout, policy.reward_weights, plugins)
    without_file = " ".join(sorted(plugin.name for plugin in used if plugin.source is None))
    return {
        **({PLUGINS_NOT_OF_A_FILE: without_file} if without_file else {}),
        **{f"{PLUGIN_HASH}{name}": sha256 for name, sha256 in plugin_hashes(used).items()},
    }


def class_name(value: object) -> str:
    """Return the full name of a value's class."""
    return f"{type(value).__module__}.{type(value).__qualname__}"
