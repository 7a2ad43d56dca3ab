"""Print the README's table of what the shipped policy achieves, from its evaluation.json."""

from __future__ import annotations

from pathlib import Path

from waypointctl.evaluation.result import CaseResult, read_evaluation

ROOT = Path(__file__).resolve().parent.parent
HEAD = """\
| path | success | 95 % interval | the paper | falls | mean time | SPL |
|---|---|---|---|---|---|---|"""


def table(evaluation: Path) -> str:
    """Return an evaluation as a Markdown table."""
    return "\n".join([HEAD, *(_row(case) for case in read_evaluation(evaluation).cases)])


def block() -> str:
    """Return the README's table."""
    return table(ROOT / "policies" / "ant-waypoint" / "evaluation.json")


def _row(case: CaseResult) -> str:
    path = " → ".join(f"({x:g}, {y:g})" for x, y in case.waypoints)
    low, high = case.wilson95
    paper = "" if case.paper is None else f"{case.paper:.0%}"
    time = "" if case.mean_time_s is None else f"{case.mean_time_s:.1f} s"
    cells = (f"{case.successes} of {case.trials}", f"{low:.1%} to {high:.1%}", paper, case.falls, time)
    return f"| {path} | {' | '.join(map(str, cells))} | {case.spl:.2f} |"


if __name__ == "__main__":
    print(block())
