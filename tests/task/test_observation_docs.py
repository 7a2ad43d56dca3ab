"""docs/observation.md lists every group, layout and term, and its plugin and recipes work."""

from __future__ import annotations

import re
from pathlib import Path

from tests.task.views import ANT
from waypointctl.task.observation import GROUPS, LAYOUTS, components_of
from waypointctl.task.reward import TERMS
from waypointctl.training.recipe_file import load_recipe, with_plugins

PAGE = (Path(__file__).parents[2] / "docs" / "observation.md").read_text(encoding="utf-8")


def rows(heading: str) -> list[list[str]]:
    """Return the cells of the table whose first column has this heading."""
    table = PAGE.split(f"| {heading} |")[1].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table]


def test_the_tables_are_complete() -> None:
    groups = [(name.strip("`"), int(count), unit) for name, count, unit, _ in rows("group")]
    assert groups == [
        (
            group.name,
            len(components_of(group, ANT)),
            ", ".join(dict.fromkeys(unit for _, unit, _ in components_of(group, ANT))),
        )
        for group in GROUPS
    ]
    assert {name.strip("`"): tuple(re.findall(r"`(\w+)`", own)) for name, own in rows("layout")} == LAYOUTS
    terms = [(name.strip("`"), unit, counts) for name, _, unit, counts in rows("term")]
    assert terms == [(term.name, term.unit, "against" if term.factor < 0 else "for") for term in TERMS]


def test_its_recipes_and_its_plugin_work(tmp_path: Path) -> None:
    plugin, _ = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "my_terms.py").write_text(plugin)
    counts = []
    for number, text in enumerate(re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)):
        (tmp_path / f"{number}.yaml").write_text(text)
        counts.append(len(with_plugins(load_recipe(tmp_path / f"{number}.yaml"), allowed=True).plugins))
    assert counts == [0, 2]
