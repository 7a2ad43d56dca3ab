"""How many threads training and evaluation should have by default, on a machine with other work and on an idle one.

Run: python bench/threads.py [--busy 0 1 2] [--rounds 3] [--steps 49152] [--out threads.json]

Each measurement is a process of its own, because OpenMP reads its settings once. In every round each setting runs once,
with the same number of busy processes beside it, in an order that changes from round to round. The table has the median
of the control steps a second, and the processor time a run took by its wall time.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import statistics
import subprocess
import sys
from collections import defaultdict
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter, process_time

RECIPE = Path("policies/ant-waypoint/train.yaml")
POLICY = Path("policies/ant-waypoint")


@dataclass(frozen=True)
class Setting:
    """Threads of the physics and of torch, and whether OpenMP's waiting threads sleep."""

    physics: int
    torch: int
    sleeping: bool

    @property
    def name(self) -> str:
        """For the table."""
        waiting = ", waiting threads sleep" if self.sleeping else ""
        return f"physics {self.physics}, torch {self.torch}{waiting}"

    @property
    def environment(self) -> dict[str, str]:
        """The process's environment; GNU OpenMP left alone lets a waiting thread spin 300,000 times."""
        spinning = {} if self.sleeping else {"GOMP_SPINCOUNT": "300000"}
        return dict(os.environ) | {"OMP_WAIT_POLICY": "PASSIVE"} | spinning


def settings(cores: int) -> list[Setting]:
    several = [Setting(cores, cores, False), Setting(cores, cores, True), Setting(cores, 1, False)]
    return [Setting(1, 1, False), *(several if cores > 1 else [])]


def train_once(setting: Setting, steps: int) -> tuple[float, float]:
    """Return control steps a second, and processor time by wall time, of some rollouts and updates."""
    import torch

    from waypointctl.training.recipe_file import load_recipe
    from waypointctl.training.state import TrainingState

    torch.set_num_threads(setting.torch)
    learner = TrainingState(load_recipe(RECIPE), setting.physics).learner
    torch.set_num_threads(setting.torch)
    learner.collect()  # the first one makes what the others use
    learner.update()
    first = learner.steps
    begin_s, begin_cpu_s = perf_counter(), process_time()
    while learner.steps < first + steps:
        learner.collect()
        learner.update()
    wall_s = perf_counter() - begin_s
    return (learner.steps - first) / wall_s, (process_time() - begin_cpu_s) / wall_s


def evaluate_once(setting: Setting, trials: int) -> tuple[float, float]:
    """Return trials a second, and processor time by wall time, of the suite `region`."""
    from waypointctl.evaluation.evaluate import evaluate
    from waypointctl.evaluation.suite import load_suite
    from waypointctl.policy.bundle import load_policy

    policy, suite = load_policy(POLICY), load_suite("region")
    begin_s, begin_cpu_s = perf_counter(), process_time()
    evaluate(policy, suite, trials, 1, setting.physics)
    wall_s = perf_counter() - begin_s
    return trials / wall_s, (process_time() - begin_cpu_s) / wall_s


def measured(what: str, setting: Setting, amount: int) -> tuple[float, float]:
    command = [sys.executable, __file__, "--one", what, json.dumps(asdict(setting)), str(amount)]
    done = subprocess.run(command, env=setting.environment, check=True, capture_output=True)
    rate, share = json.loads(done.stdout)
    return float(rate), float(share)


def be_busy() -> None:
    while True:
        pass


def campaign(busy: int, rounds: int, amounts: dict[str, int]) -> dict[str, dict[str, list[tuple[float, float]]]]:
    """Return what each round gave, by what was measured and by setting."""
    found: dict[str, dict[str, list[tuple[float, float]]]] = {what: defaultdict(list) for what in amounts}
    others = [multiprocessing.Process(target=be_busy, daemon=True) for _ in range(busy)]
    for other in others:
        other.start()
    try:
        for number in range(rounds):
            order = settings(len(os.sched_getaffinity(0)))
            for setting in order[number % len(order) :] + order[: number % len(order)]:
                for what, amount in amounts.items():
                    found[what][setting.name].append(measured(what, setting, amount))
    finally:
        for other in others:
            other.terminate()
    return found


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--busy", type=int, nargs="+", default=[0, 1, 2], help="busy processes beside it")
    arguments.add_argument("--rounds", type=int, default=3)
    arguments.add_argument("--steps", type=int, default=49_152, help="of a training")
    arguments.add_argument("--trials", type=int, default=100, help="of an evaluation")
    arguments.add_argument("--out", type=Path)
    arguments.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    options = arguments.parse_args()
    if options.one:
        what, setting, amount = options.one
        once = train_once if what == "train" else evaluate_once
        print(json.dumps(once(Setting(**json.loads(setting)), int(amount))))
        return
    results = {}
    print(f"{os.cpu_count()} cores, load average {os.getloadavg()[0]:.1f} before the first measurement")
    print("| busy processes | what | threads | rate | processor time by wall time |\n|---|---|---|---|---|")
    for busy in options.busy:
        results[busy] = campaign(busy, options.rounds, {"train": options.steps, "eval": options.trials})
        for what, by_setting in results[busy].items():
            for name, runs in by_setting.items():
                rate, share = (statistics.median(column) for column in zip(*runs, strict=True))
                unit = "steps/s" if what == "train" else "trials/s"
                print(f"| {busy} | {what} | {name} | {rate:,.0f} {unit} | {share:.2f} |", flush=True)
    if options.out:
        options.out.write_text(json.dumps(results, indent=2))


if __name__ == "__main__":
    main()
