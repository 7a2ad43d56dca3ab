from __future__ import annotations

import csv
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from waypointctl.training.curves import HEIGHT, WIDTH, curves, curves_csv, draw_curves, write_curves
from waypointctl.training.events import ENOUGH, WINDOW
from waypointctl.training.progress import ProgressRow


def run_of(seed: int, rollouts: int) -> list[ProgressRow]:
    """Return the rows of a run in which episodes end at random, and none in the first three rollouts."""
    rng = np.random.default_rng(seed)
    rows = []
    for rollout in range(rollouts):
        successes, falls, timeouts = (0, 0, 0) if rollout < 3 else map(int, rng.integers(0, 5, 3))
        steps, episodes = 100 * (rollout + 1), successes + falls + timeouts
        rows.append(ProgressRow(steps, 0.0, 0, episodes, successes, falls, timeouts, 0, 0.0))
    return rows


RUNS = {4: run_of(4, 50), 0: run_of(0, 50), 7: run_of(7, 35)}
NAMES = {"success": "successes", "fall": "falls", "timeout": "timeouts"}


def naive(rows: list[ProgressRow], quantity: str, steps: int) -> float | None:
    """Return the rate at a step, counted row by row."""
    if steps > rows[-1].steps:
        return None
    window = [row for row in rows if steps - 100 * WINDOW < row.steps <= steps]
    episodes = sum(row.episodes for row in window)
    return sum(getattr(row, NAMES[quantity]) for row in window) / episodes if episodes >= ENOUGH else None


@pytest.mark.parametrize("quantity", NAMES)
def test_each_rate_is_that_of_the_last_rollouts(quantity: str) -> None:
    found = curves(RUNS)
    assert found.seeds == (4, 0, 7)
    assert found.steps.tolist() == list(range(100, 5001, 100))
    for number, rows in enumerate(RUNS.values()):
        for place, steps in enumerate(found.steps):
            expected = naive(rows, quantity, int(steps))
            value = found.rates[quantity][number, place]
            assert np.isnan(value) if expected is None else value == pytest.approx(expected, rel=1e-12)
    # In the first 6 rollouts not all had 20 episodes that ended, and one seed's training ended after 35.
    assert np.flatnonzero(found.shared(quantity)).tolist() == list(range(6, 35))


def test_the_table_has_means_of_all_seeds_or_none() -> None:
    rows = list(csv.DictReader(StringIO(curves_csv(curves(RUNS)))))
    assert [int(row["steps"]) for row in rows] == list(range(100, 5001, 100))
    assert list(rows[0])[:7] == [
        "steps",
        "success_mean",
        "success_lowest",
        "success_highest",
        "success_seed_4",
        "success_seed_0",
        "success_seed_7",
    ]
    for quantity in NAMES:
        for row in rows:
            own = [naive(run, quantity, int(row["steps"])) for run in RUNS.values()]
            for seed, rate in zip(RUNS, own, strict=True):
                cell = row[f"{quantity}_seed_{seed}"]
                assert cell == "" if rate is None else float(cell) == pytest.approx(rate, rel=1e-5)
            summary = [row[f"{quantity}_{part}"] for part in ("mean", "lowest", "highest")]
            rates = [rate for rate in own if rate is not None]
            if len(rates) < len(own):
                assert summary == ["", "", ""]
            else:
                expected = [sum(rates) / len(rates), min(rates), max(rates)]
                assert [float(cell) for cell in summary] == pytest.approx(expected, rel=1e-5)


def test_runs_of_other_rollouts_share_no_steps_and_no_mean() -> None:
    shifted = [ProgressRow(row.steps + 50, 0, 0, row.episodes, *(0,) * 4, 0.0) for row in RUNS[4]]
    found = curves({4: RUNS[4], 5: shifted})
    assert len(found.steps) == 100
    assert not found.shared("success").any()


@pytest.mark.parametrize("seeds", [(4,), (4, 0, 7)])
def test_the_picture_is_a_png_and_the_same_each_time(seeds: tuple[int, ...]) -> None:
    found = curves({seed: RUNS[seed] for seed in seeds})
    first = draw_curves(found, "a $dollar$ name")
    assert first[:8] == b"\x89PNG\r\n\x1a\n"
    assert [int.from_bytes(first[at : at + 4], "big") for at in (16, 20)] == [WIDTH, HEIGHT]
    assert first == draw_curves(found, "a $dollar$ name")
    assert first != draw_curves(found, "another name")


def test_a_name_in_another_script_is_drawn() -> None:
    assert draw_curves(curves(RUNS), "近い").startswith(b"\x89PNG")


def test_a_run_without_an_episode_can_be_drawn() -> None:
    assert draw_curves(curves({1: RUNS[4][:2], 2: RUNS[0][:2]}), "short")


@pytest.mark.parametrize("each", [1, 3, 19, 20, 50])
def test_no_rate_is_of_fewer_than_twenty_episodes(each: int) -> None:
    rows = [ProgressRow(100 * (i + 1), 0.0, 0, each, each, 0, 0, 0, 0.0) for i in range(30)]
    first = -(-ENOUGH // each)  # the rollout in which the twentieth ends
    has = ~np.isnan(curves({1: rows}).rates["success"][0])
    assert has.tolist() == [False] * (first - 1) + [True] * (30 - first + 1)


def test_one_run_has_curves_too(tmp_path: Path) -> None:
    write_curves(tmp_path, "a name", {4: RUNS[4]})
    assert (tmp_path / "curves.csv").read_text() == curves_csv(curves({4: RUNS[4]}))
    assert (tmp_path / "curves.png").read_bytes() == draw_curves(curves({4: RUNS[4]}), "a name, seed 4")
