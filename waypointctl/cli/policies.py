"""`waypointctl policies`: list policies, show one."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from waypointctl.cli.options import policy_named
from waypointctl.display_text import printable

if TYPE_CHECKING:
    from waypointctl.evaluation.catalogue import Entry

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
    """List policies with their robot, observation layout, training and results."""
    from waypointctl.cli.console import console
    from waypointctl.cli.tui.grid_view import GridView
    from waypointctl.cli.tui.policies import policies_grid
    from waypointctl.evaluation.catalogue import catalogue, known_policies

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
    policy: Annotated[
        Path, typer.Argument(parser=policy_named, metavar="POLICY", help="Its folder, or its name.", show_default=False)
    ],
) -> None:
    """Check a policy and print its manifest, JSON as it is in the bundle."""
    from waypointctl.policy.bundle import load_policy
    from waypointctl.policy.manifest import MANIFEST

    sys.stdout.write(load_policy(policy).files[MANIFEST].decode())


def _print_json(entries: list[Entry]) -> None:
    import json

    found = [
        {
            "folder": str(entry.folder),
            "name": entry.name,
            "shipped": entry.shipped,
            "policy_sha256": entry.policy.sha256 if entry.policy else None,
            "manifest": entry.policy.manifest.model_dump(mode="json") if entry.policy else None,
            "evaluation": _of_paper(entry),
            "evaluations": [evaluation.model_dump(mode="json") for evaluation in entry.evaluations],
            "faults": entry.faults,
        }
        for entry in entries
    ]
    sys.stdout.write(f"{json.dumps({'policies': found}, indent=2)}\n")


def _of_paper(entry: Entry) -> dict[str, Any] | None:
    """Return the evaluation in evaluation.json, as the list had it before there were others."""
    found = (one for one in entry.evaluations if one.suite == "paper" and one.suite_acceptance is None)
    return next((evaluation.model_dump(mode="json") for evaluation in found), None)
