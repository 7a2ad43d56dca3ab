"""The proof of replay: the flight is flown again from the log and nothing else, and compared bit for bit."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from pydantic import ValidationError

from waypointctl.errors import InputError, LogError
from waypointctl.log.messages import Event, EventKind, State
from waypointctl.log.reader import Log, open_log
from waypointctl.log.writer import LogWriter
from waypointctl.mission.files import MissionFile, parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.ops.fly import fly
from waypointctl.ops.header import (
    MISSION,
    MISSION_FILE_HASH,
    MISSION_FOLDER,
    MJB,
    MJCF,
    POLICY_FOLDER,
    files_of_mission,
    flight_header,
    platform_facts,
)
from waypointctl.ops.sink import tee
from waypointctl.policy.bundle import LoadedPolicy, load_policy_bytes
from waypointctl.policy.manifest import MANIFEST, Manifest
from waypointctl.replay.records import compare_records
from waypointctl.replay.verdict import Divergence, Verdict, Verification
from waypointctl.replay.witness import AuditedPolicy, Diverged, LogEnded, Witness
from waypointctl.sim.robots import Robot, compile_mjb, robot_from_mjb

_DECISIVE: Final = {"version_mujoco": "MuJoCo", "architecture": "the architecture"}
_KERNELS: Final = {
    "version_numpy": "numpy",
    "version_onnxruntime": "onnxruntime",
    "processor": "the processor",
}
_PROGRAM: Final = {**_KERNELS, "version_waypointctl": "waypointctl", "source": "waypointctl's source"}
_SEED_DIGITS: Final = 19  # of 2**63
_MANIFEST: Final = f"{POLICY_FOLDER}{MANIFEST}"
_HASHED: Final = {"sha256_mission": MISSION, "sha256_mjcf": MJCF, "sha256_mjb": MJB, "sha256_policy": _MANIFEST}


def verify(path: Path) -> Verification:
    """Fly the flight of a log again and compare every message; `verify_log` for a log that is open."""
    return verify_log(open_log(path))


def verify_log(log: Log) -> Verification:
    """Fly the flight of a log again and compare every message.

    Everything comes from the log: mission, model, policy, seed. Physics is driven by the logged actions, each of
    which is computed again from the observation. States, observations, actions, reward terms and sums, events,
    commands, acknowledgements and telemetry with their times of delivery, and checkpoints have to be equal. Where
    the same program runs on the same processor, a second log is written on the way, and every record of the first
    has to be in it: viewers' topics, metadata and attachments too.

    Raises:
        LogError: the log cannot be read.
    """
    if reason := _unverifiable(log):
        return Verification(Verdict.UNVERIFIABLE, 0, None, reason, ())
    try:
        if altered := _altered(log):
            reason = f"diverged before the flight: {altered.component} is not what was recorded"
            return Verification(Verdict.DIVERGED, 0, altered, reason, ())
        mission, robot, policy = _contents(log)
    except InputError as error:
        return Verification(Verdict.UNVERIFIABLE, 0, None, f"what the log carries cannot be used: {error}", ())
    return _fly_again(log, mission, robot, policy)


def _fly_again(log: Log, mission: Mission, robot: Robot, policy: LoadedPolicy) -> Verification:
    elsewhere = _differing(log, _KERNELS)
    witness = Witness(log.messages(), bitwise=not elsewhere)
    audited = AuditedPolicy(policy, witness, bitwise=not elsewhere)
    stopped = _interrupted_at(log)

    def interrupted() -> bool:
        return witness.compared["/state"] >= stopped

    try:
        with _second_log(log, mission, robot, policy) as second:
            fly(mission, audited, tee(witness, second), robot=robot, interrupted=interrupted)
            if witness.upcoming is not None:
                raise witness.diverged("/event", "end", type(witness.upcoming).__name__, "the flight is over")
            second.close()
            records = compare_records(log, open_log(second.path)) if not _differing(log, _PROGRAM) else None
    except Diverged as error:
        if error.rounding and elsewhere:
            reason = f"rounded otherwise at step {error.where.step} on {error.where.topic}: {' and '.join(elsewhere)}"
            return Verification(Verdict.UNVERIFIABLE, witness.compared["/reward"], error.where, reason, ())
        return _diverged(error.where, witness, log)
    except LogEnded:
        ended = witness.diverged("/event", "end", "the log ends", "the flight goes on")
        return _diverged(ended.where, witness, log)
    steps = witness.compared["/action"]
    checks = _checks(witness, audited, elsewhere, records)
    same = "every bit the same" if not elsewhere else "every bit of the physics the same"
    return Verification(Verdict.EXACT, steps, None, f"{steps} control steps replayed, {same}", checks)


def _differing(log: Log, facts: Mapping[str, str]) -> list[str]:
    """Return which of the facts, key to name, are not here as they were where the log was made."""
    here = platform_facts()
    return [f"{name} differs" for key, name in facts.items() if log.metadata.get(key) != here[key]]


@contextmanager
def _second_log(log: Log, mission: Mission, robot: Robot, policy: LoadedPolicy) -> Iterator[LogWriter]:
    """Yield the writer of a log that the replay writes for comparison; it is gone afterwards."""
    mission_file = MissionFile(mission, log.attachments[MISSION], log.path)
    header = flight_header(mission_file, policy, robot)
    with TemporaryDirectory(prefix="waypointctl-") as folder, LogWriter(Path(folder) / "replay.mcap", header) as writer:
        yield writer


def _interrupted_at(log: Log) -> int:
    """Return the control step at which the flight was interrupted; one never reached if it was not."""
    last_step, ended = 0, ""
    for message in log.messages(("/state", "/event")):
        if isinstance(message, State):
            last_step = message.step
        elif isinstance(message, Event) and message.kind is EventKind.MISSION_ENDED:
            ended = message.text
    return last_step if ended.startswith("interrupted") else 1 << 62


def _unverifiable(log: Log) -> str:
    here = platform_facts()
    for key, name in _DECISIVE.items():
        there = log.metadata.get(key, "unknown")
        if there != here[key]:
            return f"{name} differs: the log was made with {there}, this is {here[key]}; no replay is exact across them"
    missing = [name for name in _HASHED.values() if name not in log.attachments]
    return f"the log does not carry {', '.join(missing)}" if missing else ""


def _altered(log: Log) -> Divergence | None:
    """Return what the log carries that is not what its metadata says, or not what its model's source compiles to."""
    for name, recorded in _recorded_hashes(log):
        found = hashlib.sha256(log.attachments.get(name, b"")).hexdigest()
        if found != recorded:
            return Divergence(-1, 0, "attachment", name, recorded, found)
    recorded = log.metadata["sha256_mjb"]  # as the attachment's has just been found to be
    compiled = hashlib.sha256(compile_mjb(log.attachments[MJCF].decode())).hexdigest()
    return None if compiled == recorded else Divergence(-1, 0, "attachment", MJB, recorded, compiled)


def _recorded_hashes(log: Log) -> Iterator[tuple[str, str]]:
    """Yield what was recorded of each attachment; that of the policy's manifest before those of its files."""
    for key, name in _HASHED.items():
        yield name, log.metadata.get(key, "no hash")
    named = (key.removeprefix(MISSION_FILE_HASH) for key in log.metadata if key.startswith(MISSION_FILE_HASH))
    for name in sorted({*named, *files_of_mission(log.attachments)}):
        yield f"{MISSION_FOLDER}{name}", log.metadata.get(f"{MISSION_FILE_HASH}{name}", "no hash")
    try:
        manifest = Manifest.model_validate_json(log.attachments[_MANIFEST])
    except ValidationError:
        return  # loading the policy says what is wrong with it
    for name, record in manifest.files.items():
        yield f"{POLICY_FOLDER}{name}", record.sha256


def _contents(log: Log) -> tuple[Mission, Robot, LoadedPolicy]:
    attachments = log.attachments
    mission = parse_mission(attachments[MISSION], f"{log.path}/{MISSION}", files_of_mission(attachments))
    seed = log.metadata.get("seed", "")
    if not seed.isdecimal() or len(seed) > _SEED_DIGITS:
        raise LogError(f"the seed is {seed[:40]!r}, which is none", where=str(log.path))
    mission = mission.model_copy(update={"seed": int(seed)})
    robot = robot_from_mjb(mission.robot, attachments[MJCF].decode(), attachments[MJB])
    return mission, robot, load_policy_bytes(_policy_files(attachments), f"{log.path}/{POLICY_FOLDER}")


def _policy_files(attachments: Mapping[str, bytes]) -> dict[str, bytes]:
    return {
        name.removeprefix(POLICY_FOLDER): data for name, data in attachments.items() if name.startswith(POLICY_FOLDER)
    }


def _diverged(where: Divergence, witness: Witness, log: Log) -> Verification:
    reason = f"diverged at step {where.step} on {where.topic}, {where.component}"
    wrote, here = _software(log.metadata), _software(platform_facts())
    if wrote != here:
        reason += (
            f" (waypointctl {wrote} wrote the log, this is {here}: another program, not an altered log, may be why)"
        )
    return Verification(Verdict.DIVERGED, witness.compared["/reward"], where, reason, ())


def _software(facts: Mapping[str, str]) -> str:
    return f"{facts.get('version_waypointctl')} ({facts.get('source')})"


def _checks(witness: Witness, audited: AuditedPolicy, elsewhere: list[str], records: int | None) -> tuple[str, ...]:
    counts = witness.compared
    actions = (
        f"within rounding ({', '.join(elsewhere)}), actions at most {audited.largest_difference:.1e} apart"
        if elsewhere
        else "computed again by the network, bit for bit"
    )
    whole = (
        "viewers' topics and metadata not compared: another program or processor wrote them"
        if records is None
        else f"{records} records of the file, viewers' topics, metadata and attachments among them, byte for byte"
    )
    return (
        f"{_several(counts['/state'], 'state')}, simulated from the first one and the logged actions alone",
        f"{_several(counts['/observation'], 'observation')} and {_several(counts['/action'], 'action')}, {actions}",
        f"{_several(counts['/reward'], 'reward')}, every term and sum",
        f"{_several(counts['/event'], 'event')}, {_several(counts['/link'], 'message')} that the link lost, doubled or "
        "let wait",
        f"{_several(counts['/command'], 'command')}, {_several(counts['/ack'], 'acknowledgement')} and "
        f"{_several(counts['/telemetry'], 'telemetry frame')}, with each time of delivery",
        f"{_several(counts['/checkpoint'], 'checkpoint')}, with the link's random streams",
        whole,
    )


def _several(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
