"""Evaluate the paper's five policies and ant-waypoint on the paper's paths, and show it in the README.

    python docs/paper_tables.py                 all of it; some minutes
    python docs/paper_tables.py --tables-only   the README's tables again, from what was saved

Each evaluation is saved beside its policy as evaluation.json. The README's block, between a comment that names this
command and the next `<!-- end -->`, is written from those files; docs/paper-paths.png is drawn from the walks.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from waypointctl.cli.evaluation_run import EvaluationFiles, chosen_suite, evaluate_loaded
from waypointctl.errors import WaypointctlError
from waypointctl.evaluation.paper_tables import paper_tables
from waypointctl.evaluation.result import EVALUATION, read_evaluation
from waypointctl.evaluation.suite import load_suite
from waypointctl.policy.bundle import load_policy
from waypointctl.policy.manifest import MANIFEST

ROOT = Path(__file__).resolve().parent.parent
POLICIES = ("policy1", "policy2", "policy3", "policy4", "policy5", "ant-waypoint")
PICTURE = "docs/paper-paths.png"
SEED = 1
ALT = "The paths that the policies walked, from above, on the paper's test cases: one panel for each table and policy"
BLOCK = re.compile(r"(<!-- python docs/paper_tables\.py -->\n).*?(\n<!-- end -->)", re.DOTALL)


def block(root: Path = ROOT) -> str:
    """Return the README's tables and picture, from the evaluations beside the policies in `root`."""
    found = [read_evaluation(folder / EVALUATION) for folder in folders(root) if (folder / EVALUATION).exists()]
    grids = paper_tables(load_suite("paper"), found)
    return "\n\n".join([*(grid.to_markdown() for grid in grids), f"![{ALT}]({PICTURE})"])


def folders(root: Path) -> list[Path]:
    """Return the folders in `root` that hold the policies; one that is not trained yet is left out."""
    named = (root / "policies" / name for name in POLICIES)
    return [folder for folder in named if (folder / MANIFEST).exists()]


def evaluate(root: Path, trials: int | None) -> None:
    """Evaluate the policies in `root`, save what was found beside them, and draw the picture."""
    suite = chosen_suite("paper", None)
    files = EvaluationFiles(tuple(folders(root)), suite, plot=root / PICTURE, save=True)
    files.refuse_unwritable()
    loaded = [(folder, load_policy(folder)) for folder in files.folders]
    files.write(evaluate_loaded(loaded, suite, trials, SEED))


def write_readme(root: Path) -> None:
    """Write the block into the README in `root`."""
    readme = root / "README.md"
    text, count = BLOCK.subn(lambda match: match[1] + block(root) + match[2], readme.read_text(encoding="utf-8"))
    if count != 1:
        sys.exit(
            f"{readme}: {count} blocks from '<!-- python docs/paper_tables.py -->' to '<!-- end -->'; one is needed"
        )
    readme.write_text(text, encoding="utf-8")


def main() -> None:
    """Do what the command line asks."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--tables-only", action="store_true", help="evaluate nothing")
    try:
        if not arguments.parse_args().tables_only:
            evaluate(ROOT, trials=None)
        write_readme(ROOT)
    except WaypointctlError as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
