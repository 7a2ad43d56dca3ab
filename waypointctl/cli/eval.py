"""`waypointctl eval`: test a policy on a suite of paths."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Iterator

    from waypointctl.evaluation.evaluate import Progress
    from waypointctl.evaluation.result import Evaluation
    from waypointctl.evaluation.suite import Suite


def evaluate_policy(
    policy: Annotated[Path, typer.Argument(metavar="POLICY", help="Its folder.", show_default=False)],
    suite: Annotated[str, typer.Option(help="The paths: 'paper', or a YAML file.")] = "paper",
    trials: Annotated[
        int | None,
        typer.Option(min=1, max=100_000, help="How often each path is walked; as the suite says.", show_default=False),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the postures that the trials start in.")] = 0,
    require: Annotated[
        float | None,
        typer.Option(min=0.0, max=1.0, help="Exit with 1 if the rate of any path is below this.", show_default=False),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Also write the JSON to this file.", show_default=False)] = None,
    threads: Annotated[int, typer.Option(min=0, max=1024, help="For the physics; 0 is one a core.")] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the table goes to stderr.")] = False,
) -> None:
    """Walk each path of a suite many times with deterministic actions and count successes, falls and timeouts."""
    from waypointctl.cli.console import console
    from waypointctl.cli.view.evaluation import evaluation_table
    from waypointctl.evaluation.evaluate import evaluate
    from waypointctl.evaluation.saved import write_evaluation
    from waypointctl.evaluation.suite import load_suite
    from waypointctl.paths import refuse_unwritable_file
    from waypointctl.policy.bundle import load_policy

    chosen = load_suite(suite)
    if out is not None:
        refuse_unwritable_file(out, "the evaluation")
    loaded = load_policy(policy)
    with _progress(chosen, trials or chosen.trials) as progress:
        evaluation = evaluate(loaded, chosen, trials, seed, threads, progress)
    people = console(stderr=json)
    people.print(evaluation_table(evaluation, people.width))
    if out is not None:
        write_evaluation(evaluation, out)
    if json:
        sys.stdout.write(evaluation.to_json())
    _require(evaluation, require)


def _require(evaluation: Evaluation, rate: float | None) -> None:
    if rate is None:
        return
    below = [case.name for case in evaluation.cases if case.rate < rate]
    if below:
        typer.echo(f"below {rate:.0%}: {', '.join(below)}", err=True)
        raise typer.Exit(1)


@contextmanager
def _progress(suite: Suite, trials: int) -> Iterator[Progress | None]:
    """Show on a terminal which path is being walked and how many of its trials have ended."""
    from waypointctl.cli.console import console

    people = console(stderr=True)
    if not people.is_terminal:
        yield None
        return
    from rich.progress import Progress as Bars

    with Bars(console=people, transient=True) as bars:
        tasks = {case.name: bars.add_task(case.name, total=trials) for case in suite.walked}
        yield lambda case, ended: bars.update(tasks[case], completed=ended)
