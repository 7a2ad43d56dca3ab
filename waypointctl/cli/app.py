"""The commands of `waypointctl`. Each is loaded when it is used: a command pays for no other one's options."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Annotated, Any, Final, cast

import typer
from typer.core import TyperGroup

from waypointctl import __version__

# Module in cli/ and name in it: a function, or a group of commands.
_COMMANDS: Final = {
    "run": ("run", "run"),
    "replay": ("replay", "replay"),
    "info": ("info", "info"),
    "validate": ("validate", "validate"),
    "init": ("init", "init"),
    "fmt": ("fmt", "fmt"),
    "import": ("import_mission", "import_mission"),
    "schema": ("schema", "schema"),
    "train": ("train", "train_policy"),
    "eval": ("eval", "evaluate_policy"),
    "policies": ("policies", "policies"),
    "study": ("study", "study"),
}


class _Commands(Mapping[str, Any]):
    """The commands by name, in the order of --help."""

    def __init__(self) -> None:
        self._loaded: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        module, attribute = _COMMANDS[name]
        if name not in self._loaded:
            self._loaded[name] = _command(name, getattr(import_module(f"waypointctl.cli.{module}"), attribute))
        return self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        return iter(_COMMANDS)

    def __len__(self) -> int:
        return len(_COMMANDS)


def _command(name: str, what: Any) -> Any:
    """Return the command of a function, or of a group of commands."""
    around = typer.Typer(add_completion=False, rich_markup_mode=None)
    around.callback()(lambda: None)  # with it a single command has its name
    if isinstance(what, typer.Typer):
        around.add_typer(what, name=name)
    else:
        around.command(name)(what)
    group: Any = typer.main.get_command(around)
    return group.commands[name]


class _Group(TyperGroup):
    """The command line, with its commands not loaded yet."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes)
        self.commands = cast(Any, _Commands())


app = typer.Typer(
    name="waypointctl",
    cls=_Group,
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
