"""A policy is refused where it was made for something else, by its manifest and the outline of the robot alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from waypointctl.errors import PolicyError
from waypointctl.flight.policy_fit import refuse_misfit
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.policy.manifest import ActionSpec, Manifest, ObservationSpec
from waypointctl.robots.load import RobotOutline, load_robot, robot_names, shipped_outline

ANT = shipped_outline("ant")
Make = Callable[..., LoadedPolicy]


@pytest.fixture(scope="module")
def manifest(tmp_path_factory: pytest.TempPathFactory, make_policy: Make) -> Manifest:
    return make_policy(tmp_path_factory.mktemp("policies") / "tiny").manifest


def altered(manifest: Manifest, **parts: object) -> Manifest:
    seen = ObservationSpec.model_validate(manifest.observation.model_copy(update=parts).model_dump())
    return manifest.model_copy(update={"observation": seen})


@pytest.mark.parametrize("name", robot_names())
def test_the_outline_of_a_robot_is_that_of_the_compiled_one(name: str) -> None:
    outline, robot = shipped_outline(name), load_robot(name)
    assert outline == RobotOutline(
        name=robot.name,
        base=robot.base,
        joint_names=robot.joint_names,
        actuated=tuple(robot.actuated.tolist()),
        feet=robot.feet,
        control_period_ns=robot.control_period_ns,
    )
    assert outline.num_actions == robot.num_actions


def test_a_policy_that_fits_passes(manifest: Manifest) -> None:
    refuse_misfit(manifest, ANT)
    refuse_misfit(manifest, load_robot("ant"))


def test_another_robot_is_refused_with_where_its_policies_are(
    manifest: Manifest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    problem, rover = "policy 'tiny': made for the robot 'ant', not 'rover'", replace(ANT, name="rover")
    with pytest.raises(PolicyError) as refused:
        refuse_misfit(manifest, rover)
    assert str(refused.value) == f"{problem}\n  Give the folder of a policy that was trained for 'rover'"
    (tmp_path / "policies" / "own").mkdir(parents=True)
    other = manifest.model_copy(update={"robot": "rover"})
    (tmp_path / "policies" / "own" / "manifest.json").write_text(other.model_dump_json())
    with pytest.raises(PolicyError) as refused:
        refuse_misfit(manifest, rover)
    assert str(refused.value) == f"{problem}\n  Choose a policy for 'rover': `waypointctl policies` lists them"


def test_a_layout_of_another_size_is_refused(manifest: Manifest) -> None:
    seen = manifest.observation
    less = altered(manifest, size=30, names=seen.names[:-1], units=seen.units[:-1], scales=seen.scales[:-1])
    with pytest.raises(PolicyError, match="another observation layout 'egocentric': it has 30 numbers, not 31"):
        refuse_misfit(less, ANT)


@pytest.mark.parametrize(
    ("part", "index", "value", "message"),
    [
        ("names", 0, "current.left", r": number 0 is 'current\.left', not 'current\.ahead'"),
        ("units", 2, "km", ": unit of number 2 is 'km', not 'm'"),
        ("scales", 2, 0.1, r": scale of number 2 is 0\.1, not 0\.2"),
    ],
)
def test_a_layout_of_other_quantities_is_refused(
    manifest: Manifest, part: str, index: int, value: object, message: str
) -> None:
    values = list(getattr(manifest.observation, part))
    values[index] = value
    with pytest.raises(PolicyError, match=message):
        refuse_misfit(altered(manifest, **{part: tuple(values)}), ANT)


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (ActionSpec(size=12, meaning="torque", limits=(-1.0, 1.0)), "other actions: it has 12, and the robot has 8"),
        (ActionSpec(size=8, meaning="torque", limits=(-150.0, 150.0)), r"within \[-150\.0, 150\.0\], not \[-1\.0, 1"),
    ],
)
def test_other_actions_are_refused(manifest: Manifest, action: ActionSpec, message: str) -> None:
    with pytest.raises(PolicyError, match=message):
        refuse_misfit(manifest.model_copy(update={"action": action}), ANT)


def test_another_control_period_is_refused(manifest: Manifest) -> None:
    with pytest.raises(PolicyError, match=r"control period of 20 ms, not 16\.5 ms"):
        refuse_misfit(manifest, replace(ANT, control_period_ns=16_500_000))


def test_what_only_a_plugin_defines_is_refused_with_the_plugin_that_it_was_trained_with(manifest: Manifest) -> None:
    seen = manifest.observation.model_copy(update={"layout": "custom", "groups": ("foot_clearance",)})
    trained = manifest.model_copy(update={"observation": seen, "plugins": {"my_terms.py": "a" * 64}})
    with pytest.raises(PolicyError, match=f"foot_clearance.*my_terms.py .SHA-256 {'a' * 64}.*\n.*--plugin"):
        refuse_misfit(trained, ANT)
    with pytest.raises(PolicyError, match="foot_clearance"):
        refuse_misfit(manifest.model_copy(update={"observation": seen}), ANT)


def test_a_policy_without_plugins_has_no_word_of_them_in_its_manifest(manifest: Manifest, tmp_path: Path) -> None:
    assert "plugins" not in manifest.model_dump()
    with_one = manifest.model_copy(update={"plugins": {"my_terms.py": "a" * 64}})
    assert with_one.model_dump()["plugins"] == {"my_terms.py": "a" * 64}
