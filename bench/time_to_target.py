"""Wall time from nothing to a success rate on a suite: a recipe of ours against stable-baselines3 as people tune it.

Run: python -m bench.time_to_target [--recipe policies/ant-waypoint/train.yaml] [--suite region] [--target 0.95]
                                    [--every 500000] [--peer-every 200000] [--peer-limit S] [--json]

Ours is `waypointctl train`, stopped at the target. The peer is stable-baselines3's PPO with rl-baselines3-zoo's tuned
settings for an ant, through SubprocVecEnv, on the same task: robot, observations, courses, deadlines, starts and, from
the same number of steps on, the pay of each phase. Both begin with nothing, one after the other in one run, and are
tested on the same trials of the same suite with deterministic actions; testing is not counted. The peer has a limit
(four times what ours took, unless told). Where it has not reached the target by then the ratio is a lower bound.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from bench.attempt import Attempt, Look, Stopwatch
from bench.sb3_peer import PROCESSES, train_peer
from waypointctl.errors import RecipeError, WaypointctlError
from waypointctl.evaluation.suite import Suite, load_suite
from waypointctl.training.events import CheckpointEvaluated, CheckpointSaved, TrainingEvent
from waypointctl.training.recipe import Recipe
from waypointctl.training.recipe_file import RecipeFile, load_recipe
from waypointctl.training.selection import SelectionRecipe
from waypointctl.training.train import train

RECIPE: Final = Path("policies/ant-waypoint/train.yaml")


def train_ours(recipe_file: RecipeFile, target: float, threads: int, tell: Callable[[Look], None]) -> Attempt:
    """Train as `waypointctl train` does, until the recipe's `stop_at`, the target, is met or the recipe ends."""
    stopwatch, looks, saved_s = Stopwatch(), list[Look](), 0.0

    def watch(event: TrainingEvent) -> None:
        nonlocal saved_s
        if isinstance(event, CheckpointSaved):
            saved_s = stopwatch.seconds
        if isinstance(event, CheckpointEvaluated):
            looks.append(Look(event.steps, saved_s, event.success_rate))
            tell(looks[-1])
            stopwatch.leave_out(stopwatch.seconds - saved_s)

    with TemporaryDirectory() as folder:
        train(recipe_file, Path(folder, "out"), run=Path(folder, "run"), threads=threads, on_event=watch)
    return Attempt(tuple(looks), target)


def summary(ours: Attempt, peer: Attempt, recipe: str, selection: SelectionRecipe, suite: Suite) -> dict[str, Any]:
    """Return what was found; times_faster is None where ours itself missed the target."""
    return {
        "recipe": recipe,
        "suite": suite.name,
        "trials": selection.trials,
        "seed": selection.seed,
        "target": ours.target,
        "cores": len(os.sched_getaffinity(0)),
        "ours": _described(ours),
        "peer": _described(peer),
        "times_faster": round(peer.end.training_s / ours.end.training_s, 2) if ours.reached else None,
        "lower_bound": peer.reached is None,
    }


def _described(attempt: Attempt) -> dict[str, Any]:
    return {
        "reached": attempt.reached is not None,
        **asdict(attempt.end),
        "best_success_rate": attempt.best,
        "tests": [asdict(look) for look in attempt.looks],
    }


def table(found: dict[str, Any]) -> str:
    """Return the summary as people read it, in at most 80 columns."""
    task = f"{found['target']:.0%} of {found['trials']} trials of {found['suite']}"
    lines = [
        f"{task}: {found['recipe']}, {found['cores']} cores",
        "",
        f"{'':30}{'training':>12}{'steps':>14}{'steps/s':>9}{'success':>9}",
    ]
    for who, name in (("waypointctl", "ours"), ("stable-baselines3, zoo's PPO", "peer")):
        end = found[name]
        rate = end["steps"] / end["training_s"]
        lines.append(
            f"{who:30}{end['training_s'] / 60:>8.1f} min{end['steps']:>14,}{rate:>9,.0f}{end['success_rate']:>9.1%}"
        )
    return "\n".join([*lines, "", _verdict(found)])


def _verdict(found: dict[str, Any]) -> str:
    peer, ratio = found["peer"], found["times_faster"]
    if ratio is None:
        return f"ours did not reach the target; its best was {found['ours']['best_success_rate']:.1%}"
    if found["lower_bound"]:
        return (
            f"at least {ratio:g} times faster: the peer was not there yet, its best was {peer['best_success_rate']:.1%}"
        )
    return f"{ratio:g} times faster"


def as_asked(recipe_file: RecipeFile, options: argparse.Namespace) -> RecipeFile:
    """Return the recipe that is tested on the suite every so many steps and ends at the target.

    Raises:
        RecipeError: it starts from another policy, or its evaluation has the seed that is selected by.
    """
    recipe = recipe_file.recipe if options.steps is None else recipe_file.recipe.scaled_to(options.steps)
    if recipe.warm_start is not None:
        problem = f"warm_start: {recipe.warm_start!r} was trained in time that would not be counted"
        hint = "Give a recipe that begins with nothing, as the peer does."
        raise RecipeError(problem, where=str(recipe_file.path), hint=hint)
    try:
        recipe.stopping_at(options.target)
    except ValueError as error:
        hint = "Give the recipe's evaluation another seed."
        raise RecipeError(str(error), where=str(recipe_file.path), hint=hint) from error
    evaluation = recipe.evaluation.model_copy(update={"trials": 1})  # of the paper's cases, which do not count here
    update = {"selection": selection_of(recipe, options), "evaluation": evaluation}
    return replace(recipe_file, recipe=recipe.model_copy(update=update))


def selection_of(recipe: Recipe, options: argparse.Namespace) -> SelectionRecipe:
    """Return how both sides are tested."""
    names = {"suite": "suite", "trials": "trials", "every": "every", "stop_at": "target"}
    update = {field: getattr(options, option) for field, option in names.items()}
    return (recipe.selection or SelectionRecipe()).model_copy(update=update)


def measure(options: argparse.Namespace) -> dict[str, Any]:
    recipe_file, suite = as_asked(load_recipe(options.recipe), options), load_suite(options.suite)

    def tell(who: str) -> Callable[[Look], None]:
        def line(look: Look) -> None:
            said = f"{who:5} {look.steps:>12,} steps {look.training_s:>8.0f} s {look.success_rate:>7.1%}"
            print(said, file=sys.stderr, flush=True)

        return line

    mine = train_ours(recipe_file, options.target, options.threads, tell("ours"))
    limit_s = options.peer_limit or 4 * mine.end.training_s
    theirs = train_peer(recipe_file.recipe, suite, options.peer_every, limit_s, options.peer_processes, tell("peer"))
    selection = selection_of(recipe_file.recipe, options)
    return summary(mine, theirs, recipe_file.recipe.name, selection, suite)


def parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser(description="Wall time to a success rate, against stable-baselines3 as tuned.")
    made.add_argument("--recipe", type=Path, default=RECIPE)
    made.add_argument("--suite", default="region", help="one that comes with waypointctl")
    made.add_argument("--target", type=_rate, default=0.95, help="success rate, 0 to 1")
    made.add_argument("--trials", type=_positive, default=200, help="of each of the suite's cases, in every test")
    made.add_argument("--every", type=_positive, default=500_000, help="control steps of ours between tests")
    made.add_argument("--steps", type=_positive, help="shorten or stretch the recipe to this many")
    made.add_argument("--threads", type=int, default=0, help="of ours; 0 is one a core")
    made.add_argument("--peer-every", type=_positive, default=200_000, help="control steps of the peer between tests")
    made.add_argument("--peer-limit", type=float, help="seconds of training; four times what ours took unless told")
    made.add_argument("--peer-processes", type=_positive, default=PROCESSES)
    made.add_argument("--json", action="store_true")
    return made


def _positive(text: str) -> int:
    number = int(text) if text.isascii() and text.isdecimal() else 0
    if not number:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number > 0")
    return number


def _rate(text: str) -> float:
    try:
        rate = float(text)
    except ValueError:
        rate = 0.0
    if not 0 < rate <= 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a success rate above 0, up to 1")
    return rate


def main() -> None:
    options = parser().parse_args()
    try:
        found = measure(options)
    except WaypointctlError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
    print(json.dumps(found, indent=2) if options.json else table(found))


if __name__ == "__main__":
    main()
