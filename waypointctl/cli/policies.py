"""`waypointctl policies`: list policies, show one."""

from __future__ import annotations

import sys
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer
from typer.core import TyperGroup

from waypointctl.cli.options import policy_named
from waypointctl.display_text import printable, shell_word
from waypointctl.evaluation.grid import Column, Grid

if TYPE_CHECKING:
    from collections.abc import Sequence

    from waypointctl.evaluation.result import CaseResult, Evaluation
    from waypointctl.evaluation.saved import Entry
    from waypointctl.training.sb3_import import Imported


_DEFAULT = "list"


class _ListByDefault(TyperGroup):
    """A group whose first argument may be a folder: `policies DIR` is `policies list DIR`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if not args or (args[0] not in self.commands and args[0] not in ctx.help_option_names):
            args = [_DEFAULT, *args]
        return super().parse_args(ctx, args)


policies = typer.Typer(cls=_ListByDefault, help="List policies, or show one.")


@policies.command("list")
def list_policies(
    folder: Annotated[
        Path | None,
        typer.Argument(
            metavar="[DIR]", help="The folder to search.", show_default="waypointctl's own policies, and ./policies"
        ),
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """List policies with their robot, layout, training and results."""
    from waypointctl.cli.console import console
    from waypointctl.cli.tui.tables import GridView
    from waypointctl.evaluation.saved import catalogue, known_policies

    entries = known_policies() if folder is None else catalogue(folder)
    if json:
        _print_json(entries)
    elif folder is None or entries:
        console().print(GridView(policies_grid(entries)))
    else:
        typer.echo(f"no policies in {printable(folder)}; `waypointctl train RECIPE.yaml` makes one", err=True)
    for fault in (fault for entry in entries for fault in entry.faults):
        typer.echo(f"warning: {printable(fault)}", err=True)


@policies.command("show")
def show_policy(
    policy: Annotated[Path, typer.Argument(parser=policy_named, metavar="POLICY", help="Its folder, or its name.")],
    json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object: the manifest, the SHA-256, the evaluations.")
    ] = False,
) -> None:
    """Check a policy and print its manifest.

    The manifest is JSON as it is in the bundle.
    """
    from waypointctl.evaluation.saved import entry_of
    from waypointctl.policy.bundle import load_policy
    from waypointctl.policy.manifest import MANIFEST

    loaded = load_policy(policy)
    if json:
        sys.stdout.write(f"{dumps(_facts(entry_of(policy)), indent=2)}\n")
    else:
        sys.stdout.write(loaded.files[MANIFEST].decode())


def _print_json(entries: list[Entry]) -> None:
    sys.stdout.write(f"{dumps({'policies': list(map(_facts, entries))}, indent=2)}\n")


def _facts(entry: Entry) -> dict[str, Any]:
    return {
        "folder": str(entry.folder),
        "name": entry.name,
        "shipped": entry.shipped,
        "policy_sha256": entry.policy.sha256 if entry.policy else None,
        "manifest": entry.policy.manifest.model_dump(mode="json") if entry.policy else None,
        "evaluation": _of_paper(entry),
        "evaluations": [evaluation.model_dump(mode="json") for evaluation in entry.evaluations],
        "faults": entry.faults,
    }


def _of_paper(entry: Entry) -> dict[str, Any] | None:
    """Return the evaluation in evaluation.json, as the list had it before there were others."""
    found = (one for one in entry.evaluations if one.suite == "paper" and one.suite_acceptance is None)
    return next((evaluation.model_dump(mode="json") for evaluation in found), None)


@policies.command("import")
def import_policy(
    model: Annotated[Path, typer.Argument(metavar="MODEL.zip", help="What model.save() wrote.")],
    out: Annotated[Path, typer.Option(help="The policy's folder.")],
    observation: Annotated[
        str, typer.Option(help="The observation layout that it was trained on, such as egocentric.")
    ],
    robot: Annotated[str, typer.Option(help="The robot that it was trained for.")] = "ant",
    vecnormalize: Annotated[
        Path | None,
        typer.Option(metavar="FILE.pkl", help="What VecNormalize.save() wrote.", show_default="no normaliser"),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a policy that is there already.")] = False,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the rest goes to stderr.")] = False,
) -> None:
    """Make a policy of a model that stable-baselines3 saved.

    The model is an MlpPolicy of PPO, A2C, SAC or TD3.

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
    return f"{dumps(found, indent=2)}\n"


_LONG: Final = 4  # waypoints; of longer paths the legs are shown, too


def policies_grid(entries: Sequence[Entry]) -> Grid:
    """Return a row for each policy, with a column for each suite that any of them has been evaluated in."""
    suites = list(dict.fromkeys(evaluation.conditions for entry in entries for evaluation in entry.evaluations))
    columns = (
        Column("policy", is_text=True),
        Column("robot", is_text=True, spare=len(suites) + 3),
        Column("layout", is_text=True, spare=len(suites) + 2),
        Column("steps", spare=len(suites) + 1),
        *(Column(suite, is_text=True, spare=place) for place, suite in enumerate(suites or ["results"])),
    )
    return Grid("", columns, tuple(_row(entry, suites) for entry in entries))


def result_text(evaluation: Evaluation) -> str:
    """Return what an evaluation came to, in a few words."""
    if len(evaluation.cases) > 1:
        rates = [case.rate for case in evaluation.cases]
        low, high = f"{min(rates) * 100:.0f}", f"{max(rates):.0%}"
        return f"{high if min(rates) == max(rates) else f'{low}-{high}'} in {len(rates)} cases"
    (case,) = evaluation.cases
    return f"{case.rate:.1%}{_legs_text(case)}"


def _legs_text(case: CaseResult) -> str:
    """Return the rate of legs on long random paths, where it differs from that of whole paths."""
    if case.course is None or case.course.count <= _LONG or case.legs is None or case.legs_reached is None:
        return ""
    return f", legs {case.legs_reached / case.legs:.2%}"


def _row(entry: Entry, suites: Sequence[str]) -> tuple[str, ...]:
    where = f"{entry.name} (shipped)" if entry.shipped else str(entry.folder)
    none = [""] * max(0, len(suites) - 1)
    if entry.policy is None:
        return (where, "", "", "", "damaged", *none)
    manifest = entry.policy.manifest
    found = {evaluation.conditions: result_text(evaluation) for evaluation in entry.evaluations}
    results = [found.get(suite, "") for suite in suites] if found else ["not evaluated", *none]
    return (where, manifest.robot, manifest.observation.layout, f"{manifest.training.steps:,}", *results)
