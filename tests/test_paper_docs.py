"""The command that writes the README's tables of the paper, tried on policies that know nothing."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.evaluation.found import paper_evaluation
from waypointctl.evaluation.result import read_evaluation
from waypointctl.policy.bundle import LoadedPolicy

SCRIPT = runpy.run_path(str(Path(__file__).parents[1] / "docs" / "paper_tables.py"))
MARKERS = ("<!-- python docs/paper_tables.py -->", "<!-- end -->")


@pytest.fixture
def root(tmp_path: Path, make_policy: Callable[..., LoadedPolicy]) -> Path:
    make_policy(tmp_path / "policies" / "ant-waypoint", gain=0.0, name="ant-waypoint")
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").write_text(f"before\n\n{MARKERS[0]}\nold\n{MARKERS[1]}\n\nafter {MARKERS[1]}\n")
    return tmp_path


def test_the_tables_are_of_what_was_saved(root: Path) -> None:
    found = paper_evaluation("five", "waypoints", "state_goal", 8)
    (root / "policies" / "ant-waypoint" / "evaluation.json").write_text(found.to_json())
    SCRIPT["write_readme"](root)
    assert "| (7, 12) → (14, 14) | 90% | 8/10 | 49.0-94.3 |" in (root / "README.md").read_text()


@pytest.mark.slow
def test_it_evaluates_draws_and_writes_the_tables_between_the_comments(root: Path) -> None:
    SCRIPT["evaluate"](root, 1)
    SCRIPT["write_readme"](root)
    saved = read_evaluation(root / "policies" / "ant-waypoint" / "evaluation.json")
    assert (saved.suite, saved.seed, [case.trials for case in saved.cases]) == ("paper", 1, [1] * 10)
    assert (root / "docs" / "paper-paths.png").read_bytes().startswith(b"\x89PNG")
    text = (root / "README.md").read_text()
    assert text == f"before\n\n{MARKERS[0]}\n{SCRIPT['block'](root)}\n{MARKERS[1]}\n\nafter {MARKERS[1]}\n"
    assert "**Table 3: the paper's policy 5**" in text
    assert "| (7, 12) → (14, 14) | 90% | not evaluated |  | 0/1 | 0.0-79.3 |" in text
    assert "](docs/paper-paths.png)" in text


def test_a_readme_without_the_comments_is_left_alone(root: Path) -> None:
    (root / "README.md").write_text("nothing\n")
    with pytest.raises(SystemExit, match=r"README\.md: 0 blocks from"):
        SCRIPT["write_readme"](root)
    assert (root / "README.md").read_text() == "nothing\n"
