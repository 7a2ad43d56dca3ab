"""Fly the delay study and show it in docs/delay.md.

    python docs/delay_study.py                 all of it, into runs/study-delay; it goes on where it was interrupted
    python docs/delay_study.py --tables-only   the page's tables and picture again, from what was found

What was found is kept in docs/delay-study.json, the picture is docs/delay.png. The page's block, between a comment
that names this command and the next `<!-- end -->`, is written from that file.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from pathlib import Path

from waypointctl.errors import WaypointctlError
from waypointctl.studies.delay import STUDY, DelayStudy, read_study
from waypointctl.studies.picture import draw
from waypointctl.studies.tables import tables

ROOT = Path(__file__).resolve().parent.parent
PAGE = "docs/delay.md"
FOUND = "docs/delay-study.json"
DRAWN = "delay.png"
ALT = "Time until the operator knows, and share of it standing, against the round trip: a line for each autonomy"
BLOCK = re.compile(r"(<!-- python docs/delay_study\.py -->\n).*?(\n<!-- end -->)", re.DOTALL)


def block(root: Path = ROOT) -> str:
    """Return the page's picture and tables, from what was found."""
    return text_of(read_study(root / FOUND))


def text_of(study: DelayStudy) -> str:
    """Return the picture and the tables of a study."""
    return "\n\n".join([f"![{ALT}]({DRAWN})", *(grid.to_markdown() for grid in tables(study))])


def fly(root: Path) -> None:
    """Fly what has not been flown yet, and keep what was found."""
    folder = root / "runs" / "study-delay"
    levels = "mission,waypoint,short_range_goal,short_range_goal-continuous,joint"
    given = ["--policy", "policies/ant-waypoint", "--autonomy", levels, "--find-joint-limit", "--out", str(folder)]
    command = ["study", "delay", *given]
    done = subprocess.run([sys.executable, "-m", "waypointctl", *command], cwd=root, check=False)
    if done.returncode:
        sys.exit(done.returncode)
    shutil.copyfile(folder / STUDY, root / FOUND)


def write_page(root: Path) -> None:
    """Write the picture, and the block into the page in `root`."""
    page = root / PAGE
    text, count = BLOCK.subn(lambda match: match[1] + block(root) + match[2], page.read_text(encoding="utf-8"))
    if count != 1:
        sys.exit(f"{page}: {count} blocks from '<!-- python docs/delay_study.py -->' to '<!-- end -->'; one is needed")
    page.write_text(text, encoding="utf-8")
    (root / "docs" / DRAWN).write_bytes(draw(read_study(root / FOUND)))


def main() -> None:
    """Do what the command line asks."""
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--tables-only", action="store_true", help="fly nothing")
    try:
        if not arguments.parse_args().tables_only:
            fly(ROOT)
        write_page(ROOT)
    except WaypointctlError as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
