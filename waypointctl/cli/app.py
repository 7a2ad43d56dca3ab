"""The commands of `waypointctl`."""

from __future__ import annotations

from typing import Annotated

import typer

from waypointctl import __version__
from waypointctl.cli.eval import evaluate_policy
from waypointctl.cli.fmt import fmt
from waypointctl.cli.import_mission import import_mission
from waypointctl.cli.info import info
from waypointctl.cli.init import init
from waypointctl.cli.policies import import_policy, policies
from waypointctl.cli.replay import replay
from waypointctl.cli.run import run
from waypointctl.cli.schema import schema
from waypointctl.cli.study import study
from waypointctl.cli.train import train_policy
from waypointctl.cli.validate import validate

app = typer.Typer(
    name="waypointctl",
    help="Mission control for learned waypoint policies: train a policy, fly it over a slow link, verify the log.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"waypointctl {__version__}")
        raise typer.Exit


def _limits(texts: list[str] | None) -> None:
    from waypointctl.limits import set_limits

    try:
        set_limits(texts or ())
    except ValueError as error:
        raise typer.BadParameter(f"{error}.") from error


@app.callback()
def _options(
    version: bool = typer.Option(False, "--version", callback=_version, is_eager=True, help="Print the version."),
    limit: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE",
            callback=_limits,
            help="Change a limit on what is read from files, such as policy-file=256MiB; docs/limits.md lists them.",
        ),
    ] = None,
) -> None:
    """Mission control for learned waypoint policies: train a policy, fly it over a slow link, verify the log."""


app.command()(run)
app.command()(replay)
app.command()(info)
app.command()(validate)
app.command()(init)
app.command()(fmt)
app.command("import")(import_mission)
app.command()(schema)
app.command("train")(train_policy)
app.command("eval")(evaluate_policy)
policies.command("import")(import_policy)
app.add_typer(policies, name="policies")
app.add_typer(study, name="study")
