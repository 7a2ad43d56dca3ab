"""The contents of a log that a replay needs, checked against their hashes: mission, robot, policy, seed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from pydantic import ValidationError

from waypointctl.errors import LogError
from waypointctl.flight.header import (
    MISSION,
    MISSION_FILE_HASH,
    MISSION_FOLDER,
    MJB,
    NAVIGATOR_CLASS,
    POLICY_FOLDER,
    ROBOT_FILE_HASH,
    ROBOT_FOLDER,
    files_within,
    flight_header,
    platform_facts,
)
from waypointctl.flight.operator.requests import planned_waypoints
from waypointctl.flight.policy_fit import (
    GIVE_PLUGINS,
    PLUGIN_HASH,
    PLUGINS_NOT_OF_A_FILE,
    POLICY_CLASS,
    PolicyNotInLog,
    refuse_misfit,
)
from waypointctl.flight.sink import OnboardCamera
from waypointctl.log.comparison import Divergence, brief
from waypointctl.log.header import LIBRARY, LogHeader
from waypointctl.log.reader import LogReader
from waypointctl.mission.files import MissionFile, parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.policy.bundle import LoadedPolicy, load_policy_bytes
from waypointctl.policy.manifest import MANIFEST, Manifest
from waypointctl.robots.description import ROBOT_FILE
from waypointctl.robots.load import robot_of_files
from waypointctl.robots.robot import Robot
from waypointctl.task.plugins import Plugin, plugin_hashes

KERNELS: Final = {"version_numpy": "numpy", "version_onnxruntime": "onnxruntime", "processor": "the processor"}
PROGRAM: Final = {
    **KERNELS,
    "version_waypointctl": "waypointctl",
    "source": "waypointctl's source",
    "version_mcap": "mcap",
    "version_protobuf": "protobuf",
    "version_foxglove_schemas": "foxglove-schemas-protobuf",
    "version_zstandard": "zstandard",
}
_DECISIVE: Final = {"version_mujoco": "MuJoCo", "architecture": "the architecture"}
_SEED_DIGITS: Final = 19  # of 2**63
_MANIFEST: Final = f"{POLICY_FOLDER}{MANIFEST}"
_HASHED: Final = {"sha256_mission": MISSION, "sha256_mjb": MJB, "sha256_policy": _MANIFEST}


@dataclass(frozen=True, slots=True)
class LogContents:
    """The contents of a log that a replay needs."""

    mission_file: MissionFile
    robot: Robot
    policy: LoadedPolicy | PolicyNotInLog
    plugins: Sequence[Plugin] = ()

    @property
    def mission(self) -> Mission:
        """The mission, with the seed it was flown with."""
        return self.mission_file.mission

    @property
    def camera(self) -> OnboardCamera:
        """A camera of the robot, that takes the pictures of this flight."""
        return OnboardCamera(self.robot, planned_waypoints(self.mission))

    def header(self) -> LogHeader:
        """Return the header of a log of this flight that is made here."""
        return flight_header(self.mission_file, self.policy, self.robot, plugins=self.plugins)

    def header_as_in(self, log: LogReader) -> LogHeader:
        """Return the header of a log of this flight that names the program and processor that `log` names."""
        header, named = self.header(), log.metadata
        kept = {key: text for key, text in header.metadata.items() if key not in PROGRAM or key in named}
        metadata = {key: named[key] if key in PROGRAM else text for key, text in kept.items()}
        return replace(header, metadata=metadata, library=log.index.library)


def contents_of(log: LogReader, plugins: Sequence[Plugin] = ()) -> LogContents | Divergence:
    """Return the contents of a log, or the first that differs from its recorded hash or from the compiled robot.

    Args:
        log: of the flight.
        plugins: that are given; the flight used those that the log names.

    Raises:
        InputError: it cannot be used, or needs a plugin that is not given.
    """
    plugins = _plugins_of(log, plugins)
    for name, recorded in _recorded_hashes(log):
        found = hashlib.sha256(log.attachments.get(name, b"")).hexdigest()
        if found != recorded:
            return Divergence(-1, 0, "attachment", name, recorded, found)
    robot = robot_of_files(files_within(ROBOT_FOLDER, log.attachments), f"{log.path}/{ROBOT_FOLDER}".rstrip("/"))
    recorded = log.metadata["sha256_mjb"]  # equal to the attachment's, checked above
    compiled = hashlib.sha256(robot.to_mjb()).hexdigest()
    if compiled != recorded:
        return Divergence(-1, 0, "attachment", MJB, recorded, compiled)
    return _contents(log, robot, plugins)


def _contents(log: LogReader, robot: Robot, plugins: Sequence[Plugin]) -> LogContents:
    attachments = log.attachments
    mission = parse_mission(attachments[MISSION], f"{log.path}/{MISSION}", files_within(MISSION_FOLDER, attachments))
    seed = log.metadata.get("seed", "")
    if not seed.isdecimal() or len(seed) > _SEED_DIGITS:
        raise LogError(f"the seed is {seed[:40]!r}; a whole number is expected", where=str(log.path))
    mission = mission.model_copy(update={"seed": int(seed)})
    policy: LoadedPolicy | PolicyNotInLog
    if POLICY_CLASS in log.metadata:
        policy = PolicyNotInLog(log.metadata, robot)
    else:
        policy = load_policy_bytes(files_within(POLICY_FOLDER, attachments), f"{log.path}/{POLICY_FOLDER}")
    # As fly() does: the manifest defines the observations.
    refuse_misfit(policy, robot, plugins)
    return LogContents(MissionFile(mission, attachments[MISSION], log.path), robot, policy, plugins)


def _plugins_of(log: LogReader, given: Sequence[Plugin]) -> tuple[Plugin, ...]:
    """Return those of the given plugins that the flight used, as its log names them.

    Raises:
        LogError: one is missing, or has another content.
    """
    used: list[Plugin] = []
    for key in log.metadata:
        if key.startswith(PLUGIN_HASH):
            used += _of_file(key.removeprefix(PLUGIN_HASH), log.metadata[key], given)
    for name in log.metadata.get(PLUGINS_NOT_OF_A_FILE, "").split():
        found = next((plugin for plugin in given if plugin.name == name), None)
        if found is None:
            problem = f"the flight needs the plugin {brief(name)!r}, which was not loaded from a file"
            raise LogError(problem, hint=f"it is not in the log: {GIVE_PLUGINS}")
        used.append(replace(found, source=None))
    return tuple(used)


def _of_file(name: str, sha256: str, given: Sequence[Plugin]) -> Iterator[Plugin]:
    """Yield the given plugins of the file that a log names, under its name there."""
    found = False
    for plugin in given:
        if plugin.source is not None and plugin.source.sha256 == sha256:
            found = True
            yield replace(plugin, source=replace(plugin.source, name=name))
    if not found:
        other = plugin_hashes(given).get(name)
        file, needed = brief(name), sha256[:64]
        if other:
            problem = f"{file} has SHA-256 {other}, the log needs {needed}"
            raise LogError(problem, hint="give that file with --plugin")
        raise LogError(f"the plugin {file} was not given", hint=f"use --plugin {file} (SHA-256 {needed})")


def platform_differences(log: LogReader, facts: Mapping[str, str] = PROGRAM) -> list[str]:
    """Return how the program and processor that a log names differ from these, with both values."""
    here = platform_facts()
    compared = [(name, log.metadata.get(key, "unknown"), here[key]) for key, name in facts.items()]
    if facts is PROGRAM:
        compared.append(("the library", log.index.library, LIBRARY))
    return [f"{name} was {brief(was)} and is {now}" for name, was, now in compared if was != now]


def unverifiable(log: LogReader) -> str:
    """Return why no replay of a log can be exact here; nothing if one can."""
    here = platform_facts()
    for key, name in _DECISIVE.items():
        there = log.metadata.get(key, "unknown")
        if there != here[key]:
            return f"{name} differs: the log has {there}, this is {here[key]}; a replay would not be exact"
    if navigator := log.metadata.get(NAVIGATOR_CLASS):
        return f"the navigator class {brief(navigator)} is not in the log"
    needed = (*_hashed(log).values(), f"{ROBOT_FOLDER}{ROBOT_FILE}")
    missing = [name for name in needed if name not in log.attachments]
    return f"the log has no {', '.join(missing)}" if missing else ""


def _hashed(log: LogReader) -> Mapping[str, str]:
    """Return the attachments that a log must have, by the keys of their hashes."""
    return {key: name for key, name in _HASHED.items() if name != _MANIFEST or POLICY_CLASS not in log.metadata}


def _recorded_hashes(log: LogReader) -> Iterator[tuple[str, str]]:
    """Yield what was recorded of each attachment; that of the policy's manifest before those of its files."""
    for key, name in _hashed(log).items():
        yield name, log.metadata.get(key, "no hash")
    for folder, prefix in ((MISSION_FOLDER, MISSION_FILE_HASH), (ROBOT_FOLDER, ROBOT_FILE_HASH)):
        named = (key.removeprefix(prefix) for key in log.metadata if key.startswith(prefix))
        for name in sorted({*named, *files_within(folder, log.attachments)}):
            yield f"{folder}{name}", log.metadata.get(f"{prefix}{name}", "no hash")
    try:
        manifest = Manifest.model_validate_json(log.attachments.get(_MANIFEST, b""))
    except ValidationError:
        return  # loading the policy reports the error
    for name, record in manifest.files.items():
        yield f"{POLICY_FOLDER}{name}", record.sha256
