"""`waypointctl train`: train a policy by a recipe."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final

import typer

from waypointctl.cli.options import rate_from

THREADS_HELP: Final = (
    "For physics and network; 0 is the default: one a core, 8 at most, for the physics and 1 for the network, or those "
    "that a resumed run was trained with."
)


def train_policy(
    recipe: Annotated[Path, typer.Argument(metavar="RECIPE.yaml", help="What to do.", show_default=False)],
    out: Annotated[
        Path | None,
        typer.Option(help="The policy's folder when it is complete; replaces one.", show_default="the run's folder"),
    ] = None,
    runs: Annotated[Path, typer.Option(help="Where runs are kept: RUNS/<recipe>, or -2, -3, ...")] = Path("runs"),
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with the recipe's newest run, or with the run that --out names.")
    ] = False,
    extend: Annotated[
        Path | None,
        typer.Option(
            metavar="RUN",
            help="Go on from this run, a folder or a name in RUNS, whose recipe is the beginning of this one, to what "
            "this one makes from nothing.",
            show_default=False,
        ),
    ] = None,
    steps: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=10**12,
            help="Shorten or stretch all phases to this many, rounded up to whole rollouts.",
            show_default=False,
        ),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, max=2**32 - 1, help="Use this seed, not the recipe's.", show_default=False)
    ] = None,
    seeds: Annotated[
        str | None,
        typer.Option(
            metavar="N|A,B,...",
            help="Train with N seeds from the recipe's on, or with these, and compare: RUNS/<recipe>-seeds.",
            show_default=False,
        ),
    ] = None,
    stop_at: Annotated[
        float | None,
        typer.Option(
            metavar="RATE",
            callback=rate_from(0.01),
            help="End when a checkpoint has this success rate, 0.01 to 1, in its test.",
            show_default=False,
        ),
    ] = None,
    threads: Annotated[int, typer.Option(min=0, max=1024, help=THREADS_HELP)] = 0,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object; the rest goes to stderr.")] = False,
) -> None:
    """Train a policy with PPO and evaluate it on the paper's paths.

    Ctrl-C stops it with a checkpoint, which is a policy that can be tried, and --resume goes on from it to the very
    same weights.
    """
    from waypointctl.cli.train_one import train_one
    from waypointctl.cli.train_seeds import train_with_seeds
    from waypointctl.cli.training_asked import TrainingAsked

    if extend is not None:
        _refuse_with_extend({"--resume": resume, "--steps": steps, "--seeds": seeds, "--stop-at": stop_at})
        extend = next((path for path in (extend, runs / extend) if path.is_dir()), extend)
    asked = TrainingAsked(
        recipe=recipe,
        out=out,
        runs=runs,
        resume=resume,
        extend=extend,
        steps=steps,
        seed=seed,
        seeds=seeds,
        stop_at=stop_at,
        threads=threads,
        json=json,
    )
    raise typer.Exit(train_one(asked) if seeds is None else train_with_seeds(asked, seeds))


def _refuse_with_extend(options: dict[str, object]) -> None:
    for name, value in options.items():
        if value:
            raise typer.BadParameter(f"cannot be combined with --extend: {name} is for other runs", param_hint=name)
