"""The header of a flight's log: all that replay needs, its provenance, and what the mission fixes for views of it."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Final

import numpy as np

import waypointctl
from waypointctl import __version__
from waypointctl.flight.executive.rules import home_of
from waypointctl.flight.link.build import contacts_of
from waypointctl.flight.link.contacts import FOREVER_NS, Contacts
from waypointctl.flight.navigator import Navigator
from waypointctl.flight.operator.requests import planned_waypoints
from waypointctl.flight.policy_fit import class_name, plugin_facts, policy_facts, reward_weights
from waypointctl.log.header import Attachment, ContactWindows, LogHeader, MissionSetting
from waypointctl.mission.files import MissionFile
from waypointctl.mission.mission import Mission
from waypointctl.mission.onboard import zones_of
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.protocol import Policy
from waypointctl.robots.robot import Robot
from waypointctl.sim.kinematics import RobotKinematics
from waypointctl.sim.stepping import integration_components
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
_DECISIVE_PARTS: Final = ("mission", "sim", "robots", "task", "policy", "flight", "log", "seeding.py", "units.py")
_MEDIA_TYPES: Final = {".json": "application/json", ".xml": "application/xml", ".yaml": "application/yaml"}
CLOCK: Final = "simulation time in ns, int64, 0 at mission start; publish_time: issued, log_time: arrived"


def setting_of(mission: Mission) -> MissionSetting:
    """Return what a mission fixes.

    Raises:
        MissionError: a file that its link refers to is missing or broken.
    """
    onboard = mission.onboard
    return MissionSetting(
        home=home_of(mission),
        may_return=onboard.home.position_m is not None or "return_home" in _reactions(mission),
        zones=zones_of(onboard.geofence),
        up=_windows(contacts_of(mission.link.up, mission.files)),
        down=_windows(contacts_of(mission.link.down, mission.files)),
    )


def _reactions(mission: Mission) -> Iterator[str]:
    """Yield what the rules on board and the schedule make the robot do."""
    onboard = mission.onboard
    yield mission.failure_rule.then
    if onboard.link_loss is not None:
        yield onboard.link_loss.do
    if onboard.geofence.keep_in or onboard.geofence.keep_out:
        yield onboard.geofence.do
    yield from (command.do for command in mission.schedule)


def _windows(contacts: Contacts) -> ContactWindows | None:
    """Return when there is contact; None for a link that is always there."""
    begin_ns = np.array([window.begin_ns for window in contacts.windows], np.int64)
    end_ns = np.array([window.end_ns for window in contacts.windows], np.int64)
    if len(begin_ns) == 1 and (begin_ns[0], end_ns[0]) == (0, FOREVER_NS):
        return None
    return ContactWindows(begin_ns, end_ns, contacts.period_ns)


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
            *_attached(MISSION_FOLDER, mission_file.files, "text/plain"),
            *_attached(ROBOT_FOLDER, robot.files),
            Attachment(MJB, "application/octet-stream", mjb),
            *_attached(POLICY_FOLDER, policy.files if isinstance(policy, LoadedPolicy) else {}),
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
            **policy_facts(policy),
            **({} if navigator is None else {NAVIGATOR_CLASS: class_name(navigator)}),
            **plugin_facts(policy, plugins),
            **_hashes(MISSION_FILE_HASH, mission_file.files),
            **_hashes(ROBOT_FILE_HASH, robot.files),
            **platform_facts(),
        },
    )


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


def _attached(folder: str, files: Mapping[str, bytes], kind: str | None = None) -> Iterator[Attachment]:
    for name, data in sorted(files.items()):
        media_type = _MEDIA_TYPES.get(Path(name).suffix.lower(), "application/octet-stream")
        yield Attachment(f"{folder}{name}", kind or media_type, data)


def _hashes(prefix: str, files: Mapping[str, bytes]) -> dict[str, str]:
    return {f"{prefix}{name}": hashlib.sha256(data).hexdigest() for name, data in sorted(files.items())}
