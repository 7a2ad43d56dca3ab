"""The header of a flight's log: everything that replay needs, and its provenance."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter, ValidationError

import waypointctl
from waypointctl import __version__
from waypointctl.errors import LogError
from waypointctl.flight.navigator.navigator import Navigator
from waypointctl.flight.operator.operator import planned_waypoints
from waypointctl.flight.policy_fit import reward_weights
from waypointctl.flight.setting import setting_of
from waypointctl.log.header import Attachment, LogHeader
from waypointctl.mission.files import MissionFile
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.protocol import Policy
from waypointctl.robots.robot import Robot
from waypointctl.sim.kinematics import RobotKinematics
from waypointctl.sim.single import integration_components
from waypointctl.task.plugins import Plugin
from waypointctl.task.reward import RewardFunction

MISSION: Final = "mission.yaml"
MISSION_FOLDER: Final = "mission/"  # of the files that the mission refers to
MISSION_FILE_HASH: Final = "sha256_mission/"
ROBOT_FOLDER: Final = "robot/"  # of robot.yaml, the MJCF and what it names
ROBOT_FILE_HASH: Final = "sha256_robot/"
MJB: Final = "model.mjb"
POLICY_FOLDER: Final = "policy/"
NAVIGATOR_CLASS: Final = "navigator_class"  # of a navigator of the caller's own: the log does not carry it
POLICY_CLASS: Final = "policy_class"  # of a policy that is not a bundle: the log does not carry it
REWARD_WEIGHTS: Final = "reward_weights"  # of such a policy, JSON
_WEIGHTS: Final = TypeAdapter(dict[str, float])
_DECISIVE_PARTS: Final = ("mission", "sim", "robots", "task", "policy", "flight", "log", "seeding.py", "units.py")
_MEDIA_TYPES: Final = {".json": "application/json", ".xml": "application/xml", ".yaml": "application/yaml"}
CLOCK: Final = "simulation time in ns, int64, 0 at mission start; publish_time: issued, log_time: arrived"


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
        names = tuple(self._metadata.get("observation_layout", "").split())
        return names if len(names) > 1 else "".join(names)

    @property
    def reward_weights(self) -> Mapping[str, float]:
        """The weight of each reward term."""
        return self._weights

    def act(self, observation: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return zeros: its actions are not known."""
        return np.zeros((len(observation), self._robot.num_actions))


def flight_header(
    mission_file: MissionFile,
    policy: Policy,
    robot: Robot,
    navigator: Navigator | None = None,
    plugins: Sequence[Plugin] = (),
) -> LogHeader:
    """Return the header of the log of a flight."""
    terms = RewardFunction(reward_weights(policy, plugins), plugins).names
    mjb = robot.to_mjb()
    mission = mission_file.mission
    return LogHeader(
        robot=robot.name,
        kinematics=RobotKinematics(robot),
        waypoints=planned_waypoints(mission),
        setting=setting_of(mission),
        attachments=(
            Attachment(MISSION, "application/yaml", mission_file.source),
            *(
                Attachment(f"{MISSION_FOLDER}{name}", "text/plain", data)
                for name, data in sorted(mission_file.files.items())
            ),
            *(
                Attachment(f"{ROBOT_FOLDER}{name}", _media_type(name), data)
                for name, data in sorted(robot.files.items())
            ),
            Attachment(MJB, "application/octet-stream", mjb),
            *(
                Attachment(f"{POLICY_FOLDER}{name}", _media_type(name), data)
                for name, data in sorted(policy.files.items() if isinstance(policy, LoadedPolicy) else ())
            ),
        ),
        metadata={
            "mission": mission.name,
            "seed": str(mission.seed),
            "autonomy": mission.autonomy,
            "policy": policy.name,
            "observation_layout": layout if isinstance(layout := policy.observation_layout, str) else " ".join(layout),
            "reward_terms": " ".join(terms),
            "control_period_ns": str(robot.control_period_ns),
            "physics_period_ns": str(round(robot.physics_period_s * 1e9)),
            "state_components": f"qpos:{robot.model.nq} qvel:{robot.model.nv} qacc_warmstart:{robot.model.nv}",
            "checkpoint_components": " ".join(f"{name}:{size}" for name, size in integration_components(robot)),
            "clock": CLOCK,
            "sha256_mission": hashlib.sha256(mission_file.source).hexdigest(),
            "sha256_mjb": hashlib.sha256(mjb).hexdigest(),
            **_policy_facts(policy),
            **({} if navigator is None else {NAVIGATOR_CLASS: _class_name(navigator)}),
            **{
                f"{MISSION_FILE_HASH}{name}": hashlib.sha256(data).hexdigest()
                for name, data in sorted(mission_file.files.items())
            },
            **{
                f"{ROBOT_FILE_HASH}{name}": hashlib.sha256(data).hexdigest()
                for name, data in sorted(robot.files.items())
            },
            **platform_facts(),
        },
    )


def _policy_facts(policy: Policy) -> dict[str, str]:
    """Return the hash of a bundle; of another policy its class, and what replay needs of it besides its actions."""
    if isinstance(policy, LoadedPolicy):
        return {"sha256_policy": policy.sha256}
    name = policy.class_name if isinstance(policy, PolicyNotInLog) else _class_name(policy)
    return {POLICY_CLASS: name, REWARD_WEIGHTS: json.dumps(dict(policy.reward_weights))}


def _class_name(value: object) -> str:
    return f"{type(value).__module__}.{type(value).__qualname__}"


@cache
def platform_facts() -> Mapping[str, str]:
    """Return what decides a log's bytes besides mission, policy and seed: versions and the processor."""
    return {
        "version_waypointctl": __version__,
        "source": source_revision(),
        "version_mujoco": version("mujoco"),
        "version_numpy": version("numpy"),
        "version_onnxruntime": version("onnxruntime"),
        "version_mcap": version("mcap"),
        "version_protobuf": version("protobuf"),
        "version_foxglove_schemas": version("foxglove-schemas-protobuf"),
        "version_zstandard": version("zstandard"),
        "architecture": platform.machine(),
        "processor": _processor(),
    }


@cache
def source_revision() -> str:
    """Return a short hash of the code that decides a flight and its log: code changes within a version."""
    package = Path(waypointctl.__file__).parent
    digest = hashlib.sha256()
    for part in _DECISIVE_PARTS:
        for path in sorted((package / part).rglob("*.py") if (package / part).is_dir() else [package / part]):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def files_within(folder: str, attachments: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return a log's attachments in a folder, by their names in there: those of the mission, the robot, the policy."""
    return {name.removeprefix(folder): data for name, data in attachments.items() if name.startswith(folder)}


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    facts = (line.partition(":")[2].strip() for line in lines if line.startswith(("model name", "flags")))
    name, flags = next(facts, ""), next(facts, "")
    # Float kernels are chosen by the processor's features, so the name alone is not enough; numpy's can be switched.
    features = f"{flags} {np.show_config(mode='dicts')['SIMD Extensions']}"
    return f"{name} ({hashlib.sha256(features.encode()).hexdigest()[:8]})"


def _media_type(name: str) -> str:
    return _MEDIA_TYPES.get(Path(name).suffix.lower(), "application/octet-stream")
