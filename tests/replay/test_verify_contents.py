"""What a log carries is checked before its flight is flown again."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from tests.replay.rewriting import Flown
from waypointctl.flight import header
from waypointctl.log.reader import open_log
from waypointctl.replay.verify import Verdict, verify
from waypointctl.robots.load import load_robot


def content(flown: Flown, name: str) -> bytes:
    return open_log(flown.path).attachments[name]


@pytest.mark.parametrize(
    "name",
    [
        "mission.yaml",
        "robot/robot.yaml",
        "robot/ant.xml",
        "model.mjb",
        "policy/manifest.json",
        "policy/policy.onnx",
        "policy/weights.safetensors",
    ],
)
def test_an_altered_attachment_is_found_before_the_flight(flown: Flown, tmp_path: Path, name: str) -> None:
    data = bytearray(content(flown, name))
    data[-3] ^= 1
    found = verify(flown.rewritten(tmp_path / "altered.mcap", attachments={name: bytes(data)}))
    assert (found.verdict, found.steps) == (Verdict.DIVERGED, 0)
    where = found.first_divergence
    assert where is not None
    assert (where.step, where.topic, where.component) == (-1, "attachment", name)
    assert where.replayed == hashlib.sha256(data).hexdigest()


def test_a_compiled_model_that_is_not_what_its_source_compiles_to_is_found(flown: Flown, tmp_path: Path) -> None:
    data = bytearray(content(flown, "model.mjb"))
    data[-3] ^= 1
    found = verify(
        flown.rewritten(
            tmp_path / "altered.mcap",
            attachments={"model.mjb": bytes(data)},
            metadata={"sha256_mjb": hashlib.sha256(data).hexdigest()},
        )
    )
    assert found.verdict is Verdict.DIVERGED
    assert found.first_divergence is not None
    assert found.first_divergence.component == "model.mjb"


def test_weights_that_are_not_the_networks_lower_the_verdict(flown: Flown, tmp_path: Path) -> None:
    """The flight ran the network; whoever goes on with training takes the weights."""
    text = b"any text at all"
    manifest = json.loads(content(flown, "policy/manifest.json"))
    manifest["files"]["weights.safetensors"] = {"sha256": hashlib.sha256(text).hexdigest(), "size": len(text)}
    changed = {"policy/weights.safetensors": text, "policy/manifest.json": json.dumps(manifest).encode()}
    sha256 = hashlib.sha256(changed["policy/manifest.json"]).hexdigest()
    found = verify(flown.rewritten(tmp_path / "other.mcap", attachments=changed, metadata={"sha256_policy": sha256}))
    assert found.verdict is Verdict.EQUIVALENT
    assert found.not_compared == ("policy/weights.safetensors: it is not a safetensors file",)


@pytest.mark.parametrize(
    ("part", "field", "value", "fault"),
    [
        ("action", "limits", [-0.5, 0.5], "made for other actions"),
        ("observation", "scales", [2.0] * 31, "made for another observation layout"),
        (None, "control_period_ns", 40_000_000, "made for a control period of 40 ms"),
    ],
)
def test_a_manifest_of_a_policy_that_could_not_fly_the_flight_is_no_proof(
    flown: Flown, tmp_path: Path, part: str | None, field: str, value: object, fault: str
) -> None:
    """Other readers take from it what the observations and actions in the log mean."""
    manifest = json.loads(content(flown, "policy/manifest.json"))
    (manifest[part] if part else manifest)[field] = value
    data = json.dumps(manifest).encode()
    sha256 = hashlib.sha256(data).hexdigest()
    changed = {"policy/manifest.json": data}
    found = verify(flown.rewritten(tmp_path / "other.mcap", attachments=changed, metadata={"sha256_policy": sha256}))
    assert found.verdict is Verdict.UNVERIFIABLE
    assert fault in found.reason


def test_another_seed_than_was_flown_is_found_in_the_first_state(flown: Flown, tmp_path: Path) -> None:
    found = verify(flown.rewritten(tmp_path / "altered.mcap", metadata={"seed": "99"}))
    assert found.verdict is Verdict.DIVERGED
    assert found.first_divergence is not None
    assert found.first_divergence.step == 0


@pytest.mark.parametrize(
    ("key", "value", "named"),
    [
        ("version_mujoco", "2.3.7", "MuJoCo differs: the log has 2.3.7"),
        ("architecture", "riscv64", "riscv64"),
    ],
)
def test_another_mujoco_or_architecture_makes_a_log_unverifiable(
    flown: Flown, tmp_path: Path, key: str, value: str, named: str
) -> None:
    found = verify(flown.rewritten(tmp_path / "other.mcap", metadata={key: value}))
    assert (found.verdict, found.first_divergence) == (Verdict.UNVERIFIABLE, None)
    assert named in found.reason
    assert header.platform_facts()[key] in found.reason


@pytest.mark.parametrize("name", ["mission.yaml", "robot/robot.yaml", "model.mjb", "policy/manifest.json"])
def test_a_log_that_lacks_what_replay_needs_is_unverifiable(flown: Flown, tmp_path: Path, name: str) -> None:
    found = verify(flown.rewritten(tmp_path / "bare.mcap", attachments={name: None}))
    assert (found.verdict, found.reason) == (Verdict.UNVERIFIABLE, f"the log has no {name}")


@pytest.mark.parametrize(
    ("name", "key", "data", "reason"),
    [
        ("mission.yaml", "sha256_mission", b"name: [", "mission.yaml"),
        ("robot/ant.xml", "sha256_robot/ant.xml", b"<mujoco>", "ant.xml: is not XML"),
        ("robot/ant.xml", "sha256_robot/ant.xml", b"<mujoco><geom/></mujoco>", "ant.xml: does not compile in MuJoCo"),
        ("robot/ant.xml", "sha256_robot/ant.xml", b"<mujoco>\xff</mujoco>", "ant.xml: is not UTF-8 text"),
        ("robot/ant.xml", "sha256_robot/ant.xml", b'<robot name="r"/>', "ant.xml:1: is a URDF"),
        (
            "robot/ant.xml",
            "sha256_robot/ant.xml",
            b'<mujoco><include file="/x"/></mujoco>',
            "not in the robot's folder",
        ),
        (
            "robot/ant.xml",
            "sha256_robot/ant.xml",
            b'<mujoco><option timestep="nan"/></mujoco>',
            "is not a finite number",
        ),
        ("policy/manifest.json", "sha256_policy", b"{}", "manifest.json"),
    ],
)
def test_a_forged_attachment_that_cannot_be_used_is_said_to_be_so(
    flown: Flown, tmp_path: Path, name: str, key: str, data: bytes, reason: str
) -> None:
    metadata = {key: hashlib.sha256(data).hexdigest()}
    found = verify(flown.rewritten(tmp_path / "forged.mcap", metadata=metadata, attachments={name: data}))
    assert found.verdict is Verdict.UNVERIFIABLE
    assert reason in found.reason


def test_a_seed_that_is_no_number_is_said_to_be_so(flown: Flown, tmp_path: Path) -> None:
    found = verify(flown.rewritten(tmp_path / "forged.mcap", metadata={"seed": "many"}))
    assert found.verdict is Verdict.UNVERIFIABLE
    assert "the seed is 'many'; a whole number is expected" in found.reason


@pytest.mark.parametrize(
    ("name", "before", "after", "reason"),
    [
        ("ant.xml", 'timestep="0.01"', 'timestep="1e-9"', "its time step is 1e-09 s"),
        ("robot.yaml", "name: ant", "name: bee", "made for the robot 'ant', not 'bee'"),
        ("robot.yaml", "substeps: 2", "substeps: 3", "made for a control period of 20 ms, not 30 ms"),
        ("robot.yaml", "front_left_ankle: 45,", "fifth_ankle: 45,", "there is no joint 'fifth_ankle'"),
    ],
)
def test_a_robot_that_the_policy_could_not_fly_is_refused_hash_and_all(
    flown: Flown, tmp_path: Path, name: str, before: str, after: str, reason: str
) -> None:
    source = load_robot("ant").files[name].decode()
    assert before in source
    data = source.replace(before, after).encode()
    attachments, metadata = {f"robot/{name}": data}, {f"sha256_robot/{name}": hashlib.sha256(data).hexdigest()}
    found = verify(flown.rewritten(tmp_path / "forged.mcap", metadata=metadata, attachments=attachments))
    assert found.verdict is Verdict.UNVERIFIABLE
    assert reason in found.reason
