"""`waypointctl eval`: test policies on a suite of paths."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

from waypointctl.cli.options import PluginFiles, parsed, policy_named, rate_from, whole
from waypointctl.display_text import printable

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from waypointctl.evaluation.evaluate import Progress
    from waypointctl.evaluation.grid import Grid
    from waypointctl.evaluation.result import Evaluation
    from waypointctl.evaluation.suite import Suite


Policies: TypeAlias = Annotated[
    list[Path], typer.Argument(parser=policy_named, metavar="POLICY...", help="Policies: folders or names.")
]
AcceptanceRegion: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="SHAPE:SIZE", help="Acceptance region in place of the suite's, such as radius:0.2 or box:0.5."
    ),
]
Require: TypeAlias = Annotated[
    float | None, parsed("RATE", rate_from(0), "Exit with 1 if the success rate of a case is below this, 0 to 1.")
]


def evaluate_policy(
    policies: Policies,
    suite: Annotated[str, typer.Option(help="The suite: paper, region, anywhere, station, or a YAML file.")] = "paper",
    trials: Annotated[int | None, whole(1, 100_000, "Trials of each path.", show_default="the suite's")] = None,
    seed: Annotated[
        int, whole(0, 2**63 - 1, "Seed of start postures and random paths; training reports use the same default.")
    ] = 1,
    acceptance: AcceptanceRegion = None,
    require: Require = None,
    save: Annotated[
        bool, typer.Option("--save", help="Write evaluation.json, or evaluation-SUITE.json, into each policy's folder.")
    ] = False,
    out: Annotated[Path | None, typer.Option(help="Write the JSON to this file.")] = None,
    markdown: Annotated[Path | None, typer.Option(help="Write the tables to this file.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw the paths to this PNG.")] = None,
    force: Annotated[
        bool, typer.Option("--force", help="Replace files of another kind, and saved evaluations with more trials.")
    ] = False,
    plugin: PluginFiles = None,
    threads: Annotated[int, whole(0, 1024, "Threads for the physics; 0: one per core, at most 8.")] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the tables go to stderr.")] = False,
) -> None:
    """Run policies on each path of a suite and count successes.

    Each path has many trials, which are deterministic. Falls and time-outs are counted too.

    Several policies on the suite 'paper' give the paper's tables, with the paper's values beside the measured ones.
    """
    from waypointctl.cli.evaluation_run import EvaluationFiles, chosen_suite, evaluate_loaded, refuse_selection_trials
    from waypointctl.evaluation.result import evaluations_json, names_of
    from waypointctl.evaluation.tables import tables
    from waypointctl.policy.bundle import load_policy

    chosen = chosen_suite(suite, acceptance)
    loaded = [(folder, load_policy(folder)) for folder in policies]
    files = EvaluationFiles(
        tuple(policies), chosen, out=out, markdown=markdown, plot=plot, save=save, force=force, trials=trials
    )
    files.refuse_unwritable()
    refuse_selection_trials(loaded, chosen, seed, save=save)
    shown = _progress(chosen.used, trials or chosen.own.trials, len(policies))
    with _interruption_reported(), shown as progress:
        found = evaluate_loaded(loaded, chosen, trials, seed, threads, progress, plugin or ())
    evaluations = [one.evaluation for one in found]
    names = names_of(evaluations, policies)
    _print_tables(tables(chosen.own, evaluations, names), to_stderr=json)
    typer.echo(_threads_text(threads), err=json)
    files.write(found)
    if json:
        sys.stdout.write(evaluations_json(evaluations))
    _require(names, evaluations, require)


@contextmanager
def _interruption_reported() -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt:
        typer.echo("interrupted; nothing was written, because the evaluation is not complete", err=True)
        raise


def _threads_text(threads: int) -> str:
    from waypointctl.sim.stepping import default_threads

    number = threads or default_threads()
    return f"{number} physics thread{'' if number == 1 else 's'}{'' if threads else ' (default)'}"


def _print_tables(grids: Sequence[Grid], *, to_stderr: bool) -> None:
    from waypointctl.cli.console import console
    from waypointctl.cli.tui.tables import GridView

    people = console(stderr=to_stderr)
    for number, grid in enumerate(grids):
        if number:
            people.print()
        people.print(GridView(grid, ("--json", "--markdown")))


def _require(names: Sequence[str], evaluations: Sequence[Evaluation], rate: float | None) -> None:
    if rate is None:
        return
    several = len(evaluations) > 1
    below = [
        f"{name} {case.name}" if several else case.name
        for name, evaluation in zip(names, evaluations, strict=True)
        for case in evaluation.cases
        if case.rate < rate
    ]
    if below:
        typer.echo(f"below {rate:.0%}: {printable(', '.join(below))}", err=True)
        raise typer.Exit(1)


@contextmanager
def _progress(suite: Suite, trials: int, num_policies: int) -> Iterator[Progress | None]:
    """Show on a terminal the path under way and how many of its trials have ended."""
    from waypointctl.cli.console import console

    people = console(stderr=True)
    if not people.is_terminal:
        yield None
        return
    from rich.progress import Progress as Bars

    with Bars(console=people, transient=True) as bars:
        every = bars.add_task("all", total=num_policies * len(suite.all_cases) * trials)
        one = bars.add_task("", total=trials)
        done = 0

        def show(case: str, ended: int) -> None:
            nonlocal done
            bars.update(one, description=case, completed=ended)
            bars.update(every, completed=done + ended)
            if ended == trials:
                done += trials

        yield show
