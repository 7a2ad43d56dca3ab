"""What several seeds came to, on terminals of any width."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from rich.console import Console

from waypointctl.cli.tui.training_result import seeds_table
from waypointctl.training.seeds import SeedResult, SeedsResult, spreads

RESULTS = tuple(
    SeedResult(
        seed, f"runs/seed-{seed}", "0" * 64, 16_000_000, 12_000_000, 3767.0, 1000, rate, 0.01, 0.0, 0.98, rate, None
    )
    for seed, rate in ((0, 0.986), (7, 1.0))
)


@pytest.mark.parametrize(
    ("width", "left_out"),
    [
        (75, ""),
        (60, "selection"),
        (45, "selection, steps, time"),
        (30, "time-outs, SPL, selection, steps, time"),
    ],
)
def test_no_number_is_cut_and_what_is_left_out_is_said(width: int, left_out: str) -> None:
    screen = io.StringIO()
    Console(file=screen, width=width).print(
        seeds_table("ant", SeedsResult(RESULTS, spreads(RESULTS)), Path("seeds.json"))
    )
    text = screen.getvalue()
    assert max(map(len, text.splitlines())) <= width
    assert "…" not in text
    rows = {line.split()[0]: line.split()[1] for line in text.splitlines() if len(line.split()) > 1}
    assert (rows["0"], rows["7"], rows["mean"]) == ("98.6%", "100.0%", "99.3%")
    told, _, how = " ".join(text.split()).partition("left out: ")[2].partition("; ")
    assert told == left_out
    assert how.startswith("a wider terminal or seeds.json shows ") == bool(left_out)
