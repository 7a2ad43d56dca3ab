from __future__ import annotations

import io
from pathlib import Path

import pytest
from rich.console import Console

from tests.training.tiny import RECIPE
from waypointctl.cli.tui.training import LivePanel, PlainLines
from waypointctl.cli.tui.training_text import count, duration, line, percent, sparkline
from waypointctl.errors import RecipeError
from waypointctl.mission.yaml_source import read_model
from waypointctl.training.events import ENOUGH, CheckpointSaved, EvaluationProgress, Resumed, Threads, TrainingStatus
from waypointctl.training.recipe import Recipe

TINY = read_model(RECIPE.encode(), "tiny", Recipe, RecipeError)


def status(steps: int, success: float | None = 0.25, episodes: int = 40) -> TrainingStatus:
    return TrainingStatus(
        steps=steps,
        total_steps=1024,
        elapsed_s=3700.0,
        steps_per_s=12.8,
        phase=0 if steps < 640 else 1,
        episodes=episodes,
        success_rate=success,
        fall_rate=0.5 if episodes >= ENOUGH else None,
        timeout_rate=0.25 if episodes >= ENOUGH else None,
        mean_reward=0.517,
        schedules={"learning_rate": 5.9e-4, "entropy": 0.0},
    )


@pytest.mark.parametrize(
    ("number", "text"), [(0, "0"), (999, "999"), (11_700, "11.7 k"), (1_970_000, "1.97 M"), (16e9, "16.00 G")]
)
def test_counts(number: float, text: str) -> None:
    assert count(number) == text


@pytest.mark.parametrize(
    ("time_s", "text"), [(-3.0, "0:00"), (0.4, "0:00"), (59.6, "1:00"), (167, "2:47"), (3767, "1:02:47")]
)
def test_spans(time_s: float, text: str) -> None:
    assert duration(time_s) == text


def test_a_rate_of_nothing_is_a_dash() -> None:
    assert (percent(None), percent(0.125)) == ("-", "12%")


def test_the_sparkline_is_as_long_as_the_whole_training() -> None:
    history = [(0.0, 0.0), (0.12, 0.3), (0.2, 0.6), (0.24, 0.99), (0.5, 1.0)]
    assert sparkline(history, 10, ascii_only=False) == "▁▃█  █    "
    assert sparkline([(1.0, 0.0)], 4, ascii_only=True) == "   _"


def test_a_line_says_where_it_is() -> None:
    assert line(status(640), 2) == (
        " 62.5%  640 of 1.0 k steps  13/s  phase 2/2  success 25%  fall 50%  timeout 25%  reward 0.52  "
        "learning rate 5.90e-04  0:30 left"
    )


@pytest.mark.parametrize("episodes", [0, 1, 19, 20])
def test_a_rate_that_rests_on_few_episodes_is_not_shown(episodes: int) -> None:
    enough = episodes == 20
    early = status(640, 0.25 if enough else None, episodes)
    shown = "success 25%  fall 50%  timeout 25%" if enough else f"success -  fall -  timeout -  of {episodes} episodes"
    assert f"phase 2/2  {shown}  reward 0.52" in line(early, 2)
    people = Console(file=io.StringIO(), width=80)
    panel = LivePanel(people, TINY, "tiny", lambda: False)
    panel(status(128, None, 0))
    panel(early)
    with people.capture() as capture:
        people.print(panel.picture())
    text = "25% success, 50% fall, 25% timeout of the last 20" if enough else f"{episodes} so far; rates are shown fr"
    assert text in capture.get()
    assert any(block in capture.get() for block in "▁▂▃▄▅▆▇█") is enough


@pytest.mark.parametrize(
    ("threads", "text"),
    [
        (Threads(2, 1, requested=False), "2 for the physics, 1 for the network, the default"),
        (Threads(3, 3, requested=True), "3 for the physics, 3 for the network"),
        (Threads(2, 3, requested=False, began=3), "2 for the physics, 3 for the network, as the run began"),
        (Threads(3, 3, requested=True, began=3), "3 for the physics, 3 for the network"),
        (
            Threads(1, 1, requested=True, began=3),
            "1 for the network; the run began with 3, so its weights will not be",
        ),
    ],
)
def test_the_threads_are_told(threads: Threads, text: str) -> None:
    assert line(threads, 1).startswith("threads    ")
    assert text in line(threads, 1)
    people = Console(file=io.StringIO(), width=120)
    panel = LivePanel(people, TINY, "tiny", lambda: False)
    panel(threads)
    panel(Resumed(1024, 1024, complete=True))
    with people.capture() as capture:
        people.print(panel.picture())
    assert text[:55] in capture.get()
    assert "the training is complete at step 1024 of 1024" in capture.get()


def test_plain_lines_come_now_and_then_and_none_before_a_checkpoint_is_lost(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = [100.0]
    monkeypatch.setattr("waypointctl.cli.tui.training.time.monotonic", lambda: clock[0])
    lines = PlainLines(TINY)
    for second in range(25):
        clock[0] = 100.0 + second
        lines(status(second + 1))
    lines(CheckpointSaved(25, Path("runs/tiny/step")))
    lines(EvaluationProgress("region", False, "region", 5, 5))
    lines(EvaluationProgress("paper", True, "to-6-6", 0, 5))
    lines(EvaluationProgress("paper", True, "to-6-6", 5, 5))
    said = capsys.readouterr().err.splitlines()
    assert [text.split()[1] for text in said[:4]] == ["1", "11", "21", "25"]
    announced = "evaluating on the suite paper, 5 trials of each case"
    assert said[4:] == ["checkpoint runs/tiny/step", announced, "evaluated to-6-6"]


@pytest.mark.parametrize("width", [40, 80, 200])
@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
def test_the_panel_fits_and_tells_all(width: int, encoding: str) -> None:
    screen = io.BytesIO()
    stream = io.TextIOWrapper(screen, encoding=encoding)
    people = Console(file=stream, force_terminal=True, width=width, height=30, legacy_windows=False)
    asked = [False]
    with LivePanel(people, TINY, "tiny in runs/tiny", lambda: asked[0]) as panel:
        panel(status(128, None))
        panel(status(640))
        panel(CheckpointSaved(640, Path("runs/step")))
        panel(EvaluationProgress("paper", True, "to-6-6", 3, 100))
        asked[0] = True
    stream.flush()
    shown = Console(file=io.StringIO(), width=width, height=30)
    with shown.capture() as capture:
        shown.print(panel.picture())
    lines = capture.get().splitlines()
    assert max(len(text) for text in lines) <= width
    for part in ("tiny in runs/tiny", "640 of 1.0 k", "1:01:40 elapsed", "2 of 2", "0.517", "25% success", "runs/step"):
        assert any(part in text for text in lines), part
    assert any("to-6-6, 3 of 1" in text for text in lines)
    assert any("stopping after this update" in text for text in lines)
    assert screen.getvalue().decode(encoding)
