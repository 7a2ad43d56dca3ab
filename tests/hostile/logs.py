"""Logs whose robot, mission or policy is hostile, from a seed; what is done to the file itself is tried elsewhere."""

from __future__ import annotations

import hashlib
import random
from pathlib import Path
from typing import Final

from tests.hostile.bundles import ANY, NO, REFUSED, Attempt, Family, Sound, sealed
from tests.hostile.mutation import SECRET, damaged
from tests.policy.hostile_networks import HOSTILE
from tests.replay.rewriting import Flown
from tests.sim.hostile_models import ANT, FILES, LARGE
from waypointctl.robots.load import load_robot

REFUSALS: Final = frozenset({NO, REFUSED})


def _attempt(
    name: str,
    rng: random.Random,
    folder: Path,
    sound: Sound,
    attached: dict[str, bytes],
    may: frozenset[int] = REFUSALS,
) -> Attempt:
    flown: Flown = sound.more["flown"]
    keys = {"mission.yaml": "sha256_mission", "policy/manifest.json": "sha256_policy"}
    keys |= {name: f"sha256_{name}" for name in attached if name.startswith("robot/")}
    metadata = {keys[each]: hashlib.sha256(data).hexdigest() for each, data in attached.items() if each in keys}
    log = flown.rewritten(folder / "log.mcap", metadata=metadata, attachments=attached)
    whole = log.read_bytes()
    log.with_name("cut.mcap.part").write_bytes(whole[: len(whole) * 9 // 10])
    command = rng.choice((("replay", log.name, "--verify"), ("replay", log.name), ("run", "--resume", "cut.mcap.part")))
    return Attempt(name, command, folder, may)


def hostile_model(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    models = FILES | LARGE
    name = rng.choice(sorted(models))
    other = folder / f"{SECRET}.xml"
    other.write_text("<mujoco/>")
    source = models[name].replace(b"FILE", str(other).encode())
    return _attempt(f"model: {name}", rng, folder, sound, {"robot/ant.xml": source})


def damaged_model(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    return _attempt("model: damaged", rng, folder, sound, {"robot/ant.xml": damaged(rng, ANT.encode())}, ANY)


def damaged_description(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    source = load_robot("ant").files["robot.yaml"]
    return _attempt("robot.yaml: damaged", rng, folder, sound, {"robot/robot.yaml": damaged(rng, source)}, ANY)


def damaged_compiled_model(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    flown: Flown = sound.more["flown"]
    mjb = damaged(rng, sound.more["mjb"]) + b"\0"
    metadata = {"sha256_mjb": hashlib.sha256(mjb).hexdigest()}
    flown.rewritten(folder / "log.mcap", metadata=metadata, attachments={"model.mjb": mjb})
    return Attempt("model.mjb: damaged", ("replay", "log.mcap", "--verify"), folder, REFUSALS)


def hostile_network(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    name = rng.choice(sorted(HOSTILE))
    files = sealed(sound, **{"policy.onnx": HOSTILE[name][0]})
    attached = {f"policy/{each}": content for each, content in files.items()}
    return _attempt(f"network in a log: {name}", rng, folder, sound, attached)


LOGS: Final[tuple[Family, ...]] = (
    hostile_model,
    damaged_model,
    damaged_description,
    damaged_compiled_model,
    hostile_network,
)
