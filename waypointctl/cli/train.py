"""`waypointctl train`: train a policy by a recipe."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, TypeAlias

import typer

from waypointctl.cli.options import parsed, rate_from, whole

THREADS_HELP: Final = (
    "Threads for physics and network; 0: one per core, at most 8, for the physics and 1 for the network, or the "
    "numbers of the resumed run."
)

Recipe: TypeAlias = Annotated[Path, typer.Argument(metavar="RECIPE.yaml", help="The recipe.")]
Out: TypeAlias = Annotated[
    Path | None,
    typer.Option(help="Folder of the finished policy; replaces a policy in it.", show_default="the run's folder"),
]
Runs: TypeAlias = Annotated[Path, typer.Option(help="Folder of all runs: RUNS/<recipe>, or -2, -3, ...")]
Resume: TypeAlias = Annotated[
    bool, typer.Option("--resume", help="Continue the recipe's newest run, or the run that --out names.")
]
Extend: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        metavar="RUN",
        help="Continue this run, a folder or a name in RUNS, whose recipe is the beginning of this one; the weights "
        "are the same as of a training from the start.",
    ),
]
Steps: TypeAlias = Annotated[
    int | None, whole(1, 10**12, "Shorten or stretch all phases to this many, rounded up to whole rollouts.")
]
Seed: TypeAlias = Annotated[int | None, whole(0, 2**32 - 1, "Use this seed in place of the recipe's.")]
Seeds: TypeAlias = Annotated[
    str | None,
    typer.Option(
        metavar="N|A,B,...",
        help="Train with N seeds from the recipe's on, or with the listed ones, and compare: RUNS/<recipe>-seeds.",
    ),
]
StopAt: TypeAlias = Annotated[
    float | None,
    parsed("RATE", rate_from(0.01), "Stop when the evaluation of a checkpoint reaches this success rate, 0.01 to 1."),
]
Threads: TypeAlias = Annotated[int, whole(0, 1024, THREADS_HELP)]
AllowPlugins: TypeAlias = Annotated[
    bool, typer.Option("--allow-plugins", help="Execute the Python files in the recipe's `plugins`.")
]
Json: TypeAlias = Annotated[bool, typer.Option("--json", help="Print one JSON object; the rest goes to stderr.")]


def train_policy(
    recipe: Recipe,
    out: Out = None,
    runs: Runs = Path("runs"),
    resume: Resume = False,
    extend: Extend = None,
    steps: Steps = None,
    seed: Seed = None,
    seeds: Seeds = None,
    stop_at: StopAt = None,
    threads: Threads = 0,
    allow_plugins: AllowPlugins = False,
    json: Json = False,
) -> None:
    """Train a policy by a recipe and evaluate it on the paper's paths.

    Ctrl-C stops it with a checkpoint, which is a policy that can be evaluated and flown; --resume continues from it and
    ends in the same weights as an uninterrupted training.
    """
    from waypointctl.cli.train_run import TrainOptions, train_one, train_with_seeds

    if extend is not None:
        _refuse_with_extend({"--resume": resume, "--steps": steps, "--seeds": seeds, "--stop-at": stop_at})
        extend = next((path for path in (extend, runs / extend) if path.is_dir()), extend)
    options = TrainOptions(
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
        allow_plugins=allow_plugins,
    )
    raise typer.Exit(train_one(options) if seeds is None else train_with_seeds(options, seeds))


def _refuse_with_extend(options: dict[str, object]) -> None:
    for name, value in options.items():
        if value:
            raise typer.BadParameter(f"--extend does not accept {name}", param_hint=name)
