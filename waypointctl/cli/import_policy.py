"""`waypointctl policies import`: a model that stable-baselines3 saved becomes a policy."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from waypointctl.display_text import printable

if TYPE_CHECKING:
    from waypointctl.training.sb3_import import Imported


def import_policy(
    model: Annotated[Path, typer.Argument(metavar="MODEL.zip", help="What model.save() wrote.", show_default=False)],
    out: Annotated[Path, typer.Option(help="The policy's folder.", show_default=False)],
    observation: Annotated[
        str, typer.Option(help="The observation layout that it was trained on, such as egocentric.", show_default=False)
    ],
    robot: Annotated[str, typer.Option(help="The robot that it was trained for.")] = "ant",
    vecnormalize: Annotated[
        Path | None,
        typer.Option(metavar="FILE.pkl", help="What VecNormalize.save() wrote.", show_default="no normaliser"),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a policy that is there already.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the rest goes to stderr.")] = False,
) -> None:
    """Make a policy of a model that stable-baselines3 saved: an MlpPolicy of PPO, A2C, SAC or TD3.

    Such files are pickles, and loading them in stable-baselines3 executes code in them. Here nothing is executed:
    tensors are read without torch's reader, the settings as JSON, VecNormalize's numbers without making its
    objects. The new network's actions are compared with those of stable-baselines3's own policy. What is taken on trust
    is what it was trained on: the observations, the robot and its control period.
    """
    from waypointctl.training.recipe_file import require_packages

    require_packages()

    from waypointctl.training.sb3_import import import_sb3

    imported = import_sb3(model, out, robot=robot, observation=observation, vecnormalize=vecnormalize, force=force)
    for line in _lines(imported, out, vecnormalize):
        typer.echo(printable(line), err=json)
    if json:
        sys.stdout.write(_json(imported, out))


def _lines(imported: Imported, out: Path, vecnormalize: Path | None) -> list[str]:
    from waypointctl.display_text import shell_word
    from waypointctl.training.sb3_import import CHECKED

    manifest, network = imported.policy.manifest, imported.network
    sizes = (manifest.observation.size, *network.hidden_sizes, manifest.action.size)
    end = ", tanh at the end" if network.squash else ""
    shape = f"{' -> '.join(str(size) for size in sizes)}, {network.activation}{end}"
    normaliser = vecnormalize or "none; a model trained with VecNormalize needs its file: --vecnormalize"
    compared = f"within {imported.difference:.1g} on {CHECKED} random observations"
    trained_on = (
        f"{manifest.observation.layout!r} of the {manifest.robot}, {manifest.control_period_ns / 1e6:g} ms a step"
    )
    return [
        f"{out}: {network.algorithm}, {shape}; trained for {manifest.training.steps:,} steps",
        f"  normaliser  {normaliser}",
        f"  checked     gives stable-baselines3's own actions {compared}",
        "  executed    nothing: tensors, settings and numbers were read, pickled objects were not made",
        f"  trusted     that it was trained on the observations {trained_on}",
        f"  to try it   waypointctl eval {shell_word(str(out))}",
    ]


def _json(imported: Imported, out: Path) -> str:
    import json

    manifest, network = imported.policy.manifest, imported.network
    found = {
        "policy": str(out),
        "policy_sha256": imported.policy.sha256,
        "algorithm": network.algorithm,
        "robot": manifest.robot,
        "observation": manifest.observation.layout,
        "hidden_sizes": list(network.hidden_sizes),
        "activation": network.activation,
        "steps": manifest.training.steps,
        "source_sha256": imported.archive.sha256,
        "vecnormalize_sha256": imported.normaliser.sha256 or None,
        "largest_difference": imported.difference,
    }
    return f"{json.dumps(found, indent=2)}\n"
