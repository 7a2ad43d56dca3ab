"""Write the README's table of what ant-waypoint achieves in every suite, from the evaluations beside it.

    python docs/readme_suites.py

`waypointctl eval policies/ant-waypoint --suite SUITE --save` makes those.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from waypointctl.evaluation.result import CaseResult, Evaluation, read_evaluation

ROOT = Path(__file__).resolve().parent.parent
POLICY = "policies/ant-waypoint"
FILES = {
    "paper": "evaluation.json",
    "region": "evaluation-region.json",
    "region, within 0.2 m": "evaluation-region-radius-0.2m.json",
    "anywhere": "evaluation-anywhere.json",
    "station": "evaluation-station.json",
}
HEAD = """\
| suite | success | 95 % interval | falls | time-outs | SPL | mean speed | time to goal |
|---|---|---|---|---|---|---|---|"""
BLOCK = re.compile(r"(<!-- python docs/readme_suites\.py -->\n).*?(\n<!-- end -->)", re.DOTALL)


def block(root: Path = ROOT) -> str:
    """Return the README's table, from the evaluations in `root`."""
    rows = [_row(name, read_evaluation(root / POLICY / file)) for name, file in FILES.items()]
    return "\n".join([HEAD, *rows])


def _row(name: str, evaluation: Evaluation) -> str:
    cases = evaluation.cases
    low, high = evaluation.wilson95
    cells = (
        name,
        f"{evaluation.successes:,} of {evaluation.trials:,}{_legs(cases)}",
        f"{low:.1%} to {high:.1%}",
        str(sum(case.falls for case in cases)),
        str(sum(case.timeouts for case in cases)),
        f"{_mean([case.spl for case in cases]):.2f}",
        f"{_mean([case.mean_speed_mps for case in cases]):.2f} m/s",
        f"{_mean([case.mean_time_s for case in cases]):.1f} s",
    )
    return f"| {' | '.join(cells)} |"


def _legs(cases: tuple[CaseResult, ...]) -> str:
    tried, walked = (sum(getattr(case, field) or 0 for case in cases) for field in ("legs", "legs_reached"))
    return f"; {walked:,} of {tried:,} legs" if tried > 10 * sum(case.trials for case in cases) else ""


def _mean(of_cases: list[float | None]) -> float:
    numbers = [number for number in of_cases if number is not None]
    return sum(numbers) / len(numbers)


def main() -> None:
    """Write the block into the README."""
    readme = ROOT / "README.md"
    text, count = BLOCK.subn(lambda match: match[1] + block() + match[2], readme.read_text(encoding="utf-8"))
    if count != 1:
        sys.exit(f"{readme}: {count} blocks from '<!-- python docs/readme_suites.py -->' to '<!-- end -->', not one")
    readme.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
