"""A recipe with an observation group and a reward term of its own, from its file to a policy in flight."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.training.tiny import RECIPE, trained
from waypointctl.errors import InputError, PolicyError, RecipeError
from waypointctl.evaluation.evaluate import evaluate
from waypointctl.evaluation.suite import load_suite
from waypointctl.flight.fly import fly
from waypointctl.log.messages import Message, Observation, Reward
from waypointctl.mission.files import load_mission
from waypointctl.policy.bundle import load_policy
from waypointctl.robots.load import load_robot
from waypointctl.task.observation import layout
from waypointctl.task.plugins import load_plugins, reward_term
from waypointctl.task.reward import RewardFunction, RewardWeights
from waypointctl.training.recipe_file import RecipeFile, load_recipe, with_plugins

PLUGIN = """
import waypointctl


@waypointctl.observation_group(
    name="foot_clearance", unit="m", components=lambda robot: [f"{foot}.height" for foot in robot.feet], scale=2.0
)
def foot_clearance(view):
    return view.foot_heights


@waypointctl.reward_term(name="low_torso", unit="m")
def low_torso(view):
    return view.height - 0.5
"""
OWN = RECIPE.replace("name: tiny", "name: tiny\nplugins: [terms/my_terms.py]\nobservation: [height, foot_clearance]")
OWN = OWN.replace("fall: 50}", "fall: 50, low_torso: -0.3}")
MISSION = """
name: short
policy: p
waypoints: [[0.5 m, 0 m]]
expect: {max_time: 0.4 s}
"""


def recipe_of(folder: Path, text: str = OWN, plugin: str = PLUGIN) -> RecipeFile:
    (folder / "terms").mkdir(exist_ok=True)
    (folder / "terms" / "my_terms.py").write_text(plugin)
    (folder / "recipe.yaml").write_text(text)
    return load_recipe(folder / "recipe.yaml")


def test_a_policy_is_trained_evaluated_and_flown_with_them(tmp_path: Path) -> None:
    recipe_file = with_plugins(recipe_of(tmp_path), allowed=True)
    policy = trained(recipe_file, tmp_path / "run").policy
    seen = policy.manifest.observation
    assert (seen.layout, seen.groups) == ("custom", ("height", "foot_clearance"))
    assert seen.names[1:] == tuple(
        f"{leg}_foot.height" for leg in ("front_left", "back_left", "back_right", "front_right")
    )
    assert (seen.units[1], seen.scales) == ("m", (1.0, 2.0, 2.0, 2.0, 2.0))
    assert policy.manifest.reward["low_torso"] == -0.3
    suite = load_suite("region")
    assert evaluate(policy, suite, trials=1, plugins=recipe_file.plugins).observation == "custom"

    (tmp_path / "mission.yaml").write_text(MISSION)
    mission = load_mission(tmp_path / "mission.yaml").mission
    messages: list[Message] = []
    fly(mission, policy, messages.append, plugins=recipe_file.plugins)
    observed = [message.values for message in messages if isinstance(message, Observation)]
    assert len(observed[0]) == 5
    terms = [dict(message.terms) for message in messages if isinstance(message, Reward)]
    assert terms[0]["low_torso"] == pytest.approx(-0.3 * (observed[1][0] - 0.5))
    with pytest.raises(PolicyError, match=rf"foot_clearance.*my_terms.py .*{sha256_of(PLUGIN)}.*\n.*--plugin"):
        fly(mission, load_policy(tmp_path / "run"), messages.append)
    (tmp_path / "my_terms.py").write_text(f"{PLUGIN}# other\n")
    with pytest.raises(PolicyError, match=rf"{sha256_of(PLUGIN + '# other' + chr(10))}.*{sha256_of(PLUGIN)}"):
        fly(mission, policy, plugins=tmp_path / "my_terms.py")


def sha256_of(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def test_a_run_does_not_go_on_with_a_plugin_that_was_changed(tmp_path: Path) -> None:
    trained(with_plugins(recipe_of(tmp_path), allowed=True), tmp_path / "run", rollouts=1)
    other = PLUGIN.replace("0.5", "0.6")
    changed = with_plugins(recipe_of(tmp_path, plugin=other), allowed=True)
    with pytest.raises(RecipeError, match=f"plugins my_terms.py .*{sha256_of(PLUGIN)}.*{sha256_of(other)}"):
        trained(changed, tmp_path / "run", resume=True)
    same = with_plugins(recipe_of(tmp_path), allowed=True)
    assert trained(same, tmp_path / "run", rollouts=0, resume=True).steps == 128


def test_a_run_keeps_its_plugins_and_goes_on_without_the_originals(tmp_path: Path) -> None:
    asked, run = with_plugins(recipe_of(tmp_path), allowed=True), tmp_path / "run"
    trained(asked, run, rollouts=1)
    assert (run / "plugins" / "my_terms.py").read_text() == PLUGIN
    shutil.rmtree(tmp_path / "terms")
    kept = load_recipe(run / "train.yaml")
    with pytest.raises(RecipeError, match="--allow-plugins"):
        with_plugins(kept, allowed=False)
    result = trained(with_plugins(kept, allowed=True), run, resume=True)
    assert result.policy.manifest.plugins == {"my_terms.py": sha256_of(PLUGIN)}
    assert json.loads((run / "manifest.json").read_text())["plugins"] == {"my_terms.py": sha256_of(PLUGIN)}
    assert (run / "plugins" / "my_terms.py").read_text() == PLUGIN


def test_a_folder_called_plugins_beside_a_recipe_of_ones_own_is_no_copy(tmp_path: Path) -> None:
    recipe_file = recipe_of(tmp_path)
    (tmp_path / "plugins").mkdir()
    (tmp_path / "plugins" / "my_terms.py").write_text("raise SystemExit")
    assert recipe_file.recipe.plugin_paths == (tmp_path / "terms" / "my_terms.py",)
    (tmp_path / "checkpoints").mkdir()
    assert recipe_file.recipe.plugin_paths == (tmp_path / "plugins" / "my_terms.py",)


def test_two_plugins_of_one_name_are_refused(tmp_path: Path) -> None:
    recipe_of(tmp_path)
    (tmp_path / "my_terms.py").write_text(PLUGIN.replace("low_torso", "lower"))
    with pytest.raises(InputError, match="two plugins have the file name"):
        load_plugins([tmp_path / "terms" / "my_terms.py", tmp_path / "my_terms.py"])
    assert len(load_plugins([tmp_path / "my_terms.py", tmp_path / "my_terms.py"])) == 2


def test_a_plugin_is_executed_only_where_that_is_allowed(tmp_path: Path) -> None:
    flag = tmp_path / "executed"
    recipe_file = recipe_of(tmp_path, plugin=f"from pathlib import Path\nPath({str(flag)!r}).touch()\n{PLUGIN}")
    assert recipe_file.plugins == ()
    with pytest.raises(
        RecipeError, match=r"recipe.yaml:2:10: the recipe executes .*my_terms.py\n  Read it, then use --allow-plugins"
    ):
        with_plugins(recipe_file, allowed=False)
    assert not flag.exists()
    assert len(with_plugins(recipe_file, allowed=True).plugins) == 2
    assert flag.exists()


@pytest.mark.parametrize(
    ("old", "new", "place"),
    [
        ("low_torso: -0.3", "low_torsoo: 0.3", "low_torsoo"),
        ("[height, foot_clearance]", "[height, clearance]", "recipe.yaml:3:"),
        ("[height, foot_clearance]", "[height, height]", "recipe.yaml:3:"),
    ],
)
def test_a_name_that_nothing_defines_is_refused(tmp_path: Path, old: str, new: str, place: str) -> None:
    with pytest.raises(RecipeError, match=place):
        with_plugins(recipe_of(tmp_path, OWN.replace(old, new)), allowed=True)


@pytest.mark.parametrize("text", ["observation: [height, foot_clearance]", "observation: egocentrik"])
def test_without_plugins_only_what_is_built_in_is_a_name(tmp_path: Path, text: str) -> None:
    with pytest.raises(RecipeError, match=r"recipe.yaml:\d+:14: observation"):
        recipe_of(tmp_path, f"{RECIPE}{text}\n")
    with pytest.raises(RecipeError, match=r"recipe.yaml:\d+:\d+: phases\[1\]\.reward\.tilt"):
        recipe_of(tmp_path, RECIPE.replace("fall: 50", "tilt: 50"))


def test_built_in_groups_need_no_plugin(tmp_path: Path) -> None:
    text = f"{RECIPE}observation: [waypoint_bearings, roll_pitch, last_action, contacts]\n"
    policy = trained(recipe_of(tmp_path, text), tmp_path / "run", rollouts=1).policy
    assert policy.manifest.observation.size == 6 + 2 + 8 + 4


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("return view.foot_heights[:, :2]", r"'foot_clearance' returned the shape \(16, 2\), not \(n, 4\) with n = 16"),
        ("return view.foot_heights / 0.0", "'foot_clearance' returned .* not a finite number"),
        ("return view.nothing", "'foot_clearance' raised AttributeError"),
        ("view.position[:] = 0.0", "'foot_clearance' raised ValueError"),
        ("view.goals[:] = 0.0", "'foot_clearance' raised ValueError"),
        ("view.body.up[:] = 0.0", "'foot_clearance' raised ValueError"),
    ],
)
def test_a_group_that_fails_is_named(tmp_path: Path, body: str, message: str) -> None:
    plugin = PLUGIN.replace("return view.foot_heights", body)
    recipe_file = with_plugins(recipe_of(tmp_path, plugin=plugin), allowed=True)
    with pytest.raises(InputError, match=message), np.errstate(all="ignore"):
        trained(recipe_file, tmp_path / "run")


@pytest.mark.parametrize(
    ("plugin", "message"),
    [
        ("x = 1", "my_terms.py: defines no observation group and no reward term"),
        ("x = ", r"my_terms.py:1: is not valid Python"),
        ("import nothing_there", r"my_terms.py:1: ModuleNotFoundError"),
        ("x = 1\n\nx / 0\n", "my_terms.py:3: ZeroDivisionError: division by zero"),
        ("raise SystemExit(0)", "my_terms.py:1: SystemExit"),
        (PLUGIN.replace('name="low_torso"', 'name="Low torso"'), r"my_terms.py:\d+: .*'Low torso' is not a valid name"),
    ],
)
def test_a_file_that_is_no_plugin_is_refused(tmp_path: Path, plugin: str, message: str) -> None:
    recipe_of(tmp_path, plugin=plugin)
    with pytest.raises(InputError, match=message):
        load_plugins([tmp_path / "terms" / "my_terms.py"])


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("scale=2.0", "scale=(1.0, 2.0)"),
        ("scale=2.0", "scale=float('nan')"),
        ("scale=2.0", "scale='x'"),
        ('unit="m", components', 'unit=("m", "m"), components'),
        ('f"{foot}.height"', "1 / 0"),
        ('[f"{foot}.height" for foot in robot.feet]', "4"),
    ],
)
def test_a_group_that_is_described_wrongly_is_named(tmp_path: Path, old: str, new: str) -> None:
    assert old in PLUGIN
    recipe_file = with_plugins(recipe_of(tmp_path, plugin=PLUGIN.replace(old, new)), allowed=True)
    with pytest.raises(InputError, match="'foot_clearance'"):
        layout(recipe_file.recipe.observation, load_robot("ant"), recipe_file.plugins)


def test_a_term_may_be_called_as_a_method_of_the_weights() -> None:
    term = reward_term(name="copy", unit="1")(lambda view: view.up)
    assert RewardFunction(RewardWeights.model_validate({"copy": 2.0}), [term]).names[-1] == "copy"


def test_a_name_that_is_built_in_is_refused(tmp_path: Path) -> None:
    plugin = PLUGIN.replace('name="foot_clearance"', 'name="height"')
    with pytest.raises(RecipeError, match="two observation groups have the name 'height'"):
        with_plugins(recipe_of(tmp_path, plugin=plugin), allowed=True)
