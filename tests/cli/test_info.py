"""`waypointctl info`, from the shell's side."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from tests.log.fake_flight import flight, header
from waypointctl.cli.app import app
from waypointctl.errors import LogError
from waypointctl.log.reader import open_log
from waypointctl.log.writer import LogWriter


@pytest.fixture(scope="module")
def log_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("info") / "flight.mcap"
    with LogWriter(path, header(note="[bold]not markup[/bold]")) as sink:
        for message in flight(100):
            sink(message)
    return path


def test_json_is_one_object_with_everything(log_path: Path) -> None:
    result = CliRunner().invoke(app, ["info", str(log_path), "--json"])
    assert result.exit_code == 0
    found = json.loads(result.stdout)
    topics = {topic["name"]: topic for topic in found["topics"]}
    assert found["complete"] is True
    assert found["duration_s"] == 2.0
    assert found["outcome"] == "the mission ends"
    assert found["messages"] == sum(topic["count"] for topic in topics.values())
    assert topics["/state"] == {
        "name": "/state",
        "schema": "waypointctl.State",
        "count": 100,
        "first_ns": 0,
        "last_ns": 1_980_000_000,
        "rate_hz": 50.0,
    }
    assert {"name": "mission.yaml", "size_bytes": 11} in found["attachments"]
    assert found["metadata"]["seed"] == "7"
    assert found["size_bytes"] == log_path.stat().st_size


def test_table_for_people(log_path: Path) -> None:
    result = CliRunner().invoke(app, ["info", str(log_path)])
    assert result.exit_code == 0
    lines = [line.split() for line in result.stdout.splitlines()]
    assert ["/state", "waypointctl.State", "100", "50.0", "0.000", "1.980"] in lines
    assert ["model.mjb", "10,240"] in lines
    assert "[bold]not markup[/bold]" in result.stdout
    assert "2.000 s of simulation" in result.stdout
    assert "complete" in result.stdout
    assert "outcome: the mission ends" in result.stdout.splitlines()


@pytest.mark.parametrize("width", [40, 60, 80, 120])
def test_no_name_and_no_number_is_cut_at_any_width(log_path: Path, width: int) -> None:
    out = CliRunner().invoke(app, ["info", str(log_path)], env={"COLUMNS": str(width)}).stdout
    head, _, tables = out.partition("\n\n")
    assert "written by waypointctl" in head
    assert "…" not in out
    assert all(len(line) <= width for line in tables.splitlines())
    rows = [line.split() for line in tables.splitlines()]
    topics = {row[0]: row for row in rows if row and row[0].startswith("/")}
    opened = open_log(log_path)
    assert list(topics) == list(opened.topics)
    assert all(str(topic.count) in topics[name] for name, topic in opened.topics.items())
    for name, data in opened.attachments.items():
        assert [name, f"{len(data):,}"] in rows
    assert ("left out: schema" in out) == (width < 80)


def test_log_that_is_cut_short_is_shown_as_such(log_path: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap.part"
    cut.write_bytes(log_path.read_bytes()[:-1000])
    result = CliRunner().invoke(app, ["info", str(cut), "--json"])
    assert result.exit_code == 0
    assert json.loads(result.stdout)["complete"] is False
    assert "cut short" in CliRunner().invoke(app, ["info", str(cut)]).stdout


@pytest.mark.parametrize(
    ("is_whole", "said"),
    [(True, "the log has no outcome event"), (False, "the log has no end (the flight was killed or is still running)")],
)
def test_a_flight_whose_end_is_not_in_the_log(tmp_path: Path, is_whole: bool, said: str) -> None:
    path = tmp_path / "flight.mcap"
    with LogWriter(path, header()) as sink:
        for message in list(flight(100))[:-1]:
            sink(message)
    if not is_whole:
        path.write_bytes(path.read_bytes()[:-1000])
    assert json.loads(CliRunner().invoke(app, ["info", str(path), "--json"]).stdout)["outcome"] is None
    lines = CliRunner().invoke(app, ["info", str(path)]).stdout.splitlines()
    assert f"outcome: none, {said}" in lines


def test_what_is_no_log_is_refused(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["info", str(tmp_path / "none.mcap")])
    assert isinstance(result.exception, LogError)
    assert result.exception.exit_code == 2
