"""Hostile policies, the files beside them, and missions that refer to hostile files: what is tried, from a seed."""

from __future__ import annotations

import hashlib
import json
import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from tests.hostile.mutation import damaged, of_another_kind, reworded
from tests.policy.hostile_networks import HOSTILE

DONE, NO, REFUSED = 0, 1, 2
ANY: Final = frozenset({DONE, NO, REFUSED})

MISSION: Final = """\
name: short
policy: ./policy
waypoints:
  - {position: [2 m, 0 m], timeout: 300 ms}
link: {delay: 100 ms, jitter_file: jitter.txt, contact_plan: {file: plan.ionrc, from_node: 1, to_node: 2}}
"""
PLAN: Final = "a contact +0 +60 1 2 100000\na contact +0 +60 2 1 100000\na range +0 +60 1 2 0.1\n"
SUITE: Final = (
    "name: one\ntrials: 1\ndeadline: {first: 0.2 s, further: 0.2 s}\ncases: [{name: a, waypoints: [[1, 0]]}]\n"
)
RECIPE: Final = (
    "name: tiny\ncourse: {perimeter: legs, count: 1, leg: [1 m, 2 m]}\nphases: [{steps: 10, learning_rate: 0.001}]\n"
)


@dataclass(frozen=True, slots=True)
class Attempt:
    """A command on hostile files.

    Attributes:
        name: what was done to them.
        arguments: of waypointctl.
        folder: that it runs in.
        may: the exit codes that are right.
        says: what must stand in its output.
    """

    name: str
    arguments: tuple[str, ...]
    folder: Path
    may: frozenset[int] = ANY
    says: str = ""


@dataclass(frozen=True)
class Sound:
    """What is right, to be damaged: a small policy's files, and an evaluation of it."""

    policy: Mapping[str, bytes]
    evaluation: dict[str, Any]
    more: dict[str, Any] = field(default_factory=dict)


Family = Callable[[random.Random, Path, Sound], Attempt]


def yard(folder: Path, sound: Sound, **files: bytes) -> Path:
    """Write a mission with its files, a suite, a recipe and a policy; return the policy's folder."""
    texts = {"mission.yaml": MISSION, "plan.ionrc": PLAN, "jitter.txt": "0.01\n-0.01\n", "suite.yaml": SUITE}
    for name, text in (texts | {"train.yaml": RECIPE}).items():
        (folder / name).write_text(text)
    policy = folder / "policies" / "given"
    policy.mkdir(parents=True)
    (folder / "policy").symlink_to("policies/given")
    for name, content in (dict(sound.policy) | files).items():
        (policy / name).write_bytes(content)
    (policy / "evaluation-region.json").write_text(json.dumps(sound.evaluation))
    return policy


def sealed(sound: Sound, **changed: bytes) -> dict[str, bytes]:
    """Return a policy's files with others in their place, and the others' hashes in its manifest."""
    manifest = json.loads(sound.policy["manifest.json"])
    for name, content in changed.items():
        manifest["files"][name] = {"sha256": hashlib.sha256(content).hexdigest(), "size": len(content)}
    return changed | {"manifest.json": json.dumps(manifest).encode()}


def using(rng: random.Random, *, shown: bool = True) -> tuple[str, ...]:
    """Return a command that uses the policy."""
    commands = [
        ("run", "mission.yaml", "--out", "log.mcap"),
        ("run", "mission.yaml", "--policy", "policies/given", "--json"),
        ("eval", "policies/given", "--suite", "suite.yaml"),
        ("validate", "mission.yaml", "--policy", "policies/given"),
    ]
    if shown:
        commands += [("policies", "show", "policies/given"), ("policies",), ("policies", "--json")]
    return rng.choice(commands)


def refusing(command: tuple[str, ...]) -> frozenset[int]:
    """Return the exit codes of a command that is given a policy that must be refused.

    A list names its fault, and `validate` looks at its evaluations alone.
    """
    if command[0] == "validate":
        return frozenset({DONE, REFUSED})
    return frozenset({DONE}) if command in (("policies",), ("policies", "--json")) else frozenset({REFUSED})


def hostile_network(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    name = rng.choice(sorted(HOSTILE))
    yard(folder, sound, **sealed(sound, **{"policy.onnx": HOSTILE[name][0]}))
    command = using(rng)
    return Attempt(f"network: {name}", command, folder, refusing(command))


def damaged_network(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    model = damaged(rng, sound.policy["policy.onnx"])
    yard(folder, sound, **sealed(sound, **{"policy.onnx": model}))
    return Attempt("network: damaged", using(rng), folder)


def damaged_file(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    name = rng.choice(sorted(sound.policy))
    yard(folder, sound, **{name: damaged(rng, sound.policy[name])})
    return Attempt(f"{name}: damaged", using(rng), folder)


def other_manifest(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    manifest = reworded(rng, json.loads(sound.policy["manifest.json"]))
    yard(folder, sound, **{"manifest.json": json.dumps(manifest).encode()})
    return Attempt("manifest.json: reworded", using(rng), folder)


def other_kind(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    policy = yard(folder, sound)
    name = rng.choice(sorted(sound.policy))
    kind = of_another_kind(rng, policy / name)
    command = using(rng)
    return Attempt(
        f"{name}: {kind}", command, folder, refusing(command) | {DONE} if kind == "empty" else refusing(command)
    )


def other_evaluation(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    policy = yard(folder, sound)
    path = policy / rng.choice(("evaluation.json", "evaluation-region.json", "evaluation-\x1b[31m.json"))
    match rng.randrange(4):
        case 0:
            name = of_another_kind(rng, path)
        case 1:
            path.write_bytes(damaged(rng, json.dumps(sound.evaluation).encode()))
            name = "damaged"
        case _:
            path.write_text(json.dumps(reworded(rng, sound.evaluation)))
            name = "reworded"
    command = rng.choice((("policies",), ("policies", "--json"), ("validate", "mission.yaml")))
    may = frozenset({DONE}) if command[0] == "policies" else ANY
    return Attempt(f"evaluation: {name}", command, folder, may, says="given" if command[0] == "policies" else "")


def other_reference(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    """A file that a mission refers to, or is: of another kind, or damaged."""
    yard(folder, sound)
    name = rng.choice(("jitter.txt", "plan.ionrc", "mission.yaml"))
    if rng.random() < 0.7:
        kind = of_another_kind(rng, folder / name)
        may = frozenset({REFUSED})
    else:
        (folder / name).write_bytes(damaged(rng, (folder / name).read_bytes()))
        kind, may = "damaged", ANY
    if rng.random() < 0.2:
        return Attempt(f"{name}: {kind}", ("fmt", "--check", "mission.yaml"), folder)
    command = rng.choice((("run", "mission.yaml", "--out", "log.mcap"), ("validate", "mission.yaml")))
    return Attempt(f"{name}: {kind}", command, folder, may)


def other_suite(rng: random.Random, folder: Path, sound: Sound) -> Attempt:
    yard(folder, sound)
    name, command = rng.choice(
        (
            ("suite.yaml", ("eval", "policies/given", "--suite", "suite.yaml", "--json")),
            ("train.yaml", ("validate", "train.yaml")),
        )
    )
    if rng.random() < 0.5:
        kind = of_another_kind(rng, folder / name)
    else:
        (folder / name).write_bytes(damaged(rng, (folder / name).read_bytes()))
        kind = "damaged"
    return Attempt(f"{name}: {kind}", command, folder)


FAMILIES: Final[tuple[Family, ...]] = (
    hostile_network,
    damaged_network,
    damaged_file,
    other_manifest,
    other_kind,
    other_evaluation,
    other_reference,
    other_suite,
)


def attempts(families: tuple[Family, ...], count: int, seed: int, folder: Path, sound: Sound) -> Iterator[Attempt]:
    """Yield as many attempts, each with files in a folder of its own below `folder`."""
    for number in range(count):
        rng = random.Random(f"{seed}/{number}")
        place = folder / f"{number:05d}" / "yard"
        place.mkdir(parents=True)
        yield families[number % len(families)](rng, place, sound)
