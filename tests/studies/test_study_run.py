"""Whole studies, of robots that stand where they shall go: what they take is what the link takes."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.studies.standing import here
from waypointctl.errors import PolicyError
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.flight_log import FlightLog
from waypointctl.studies.case import DelayCase, grid
from waypointctl.studies.delay import LOGS, PICTURE, STUDY, TABLES, VALUES, DelayStudy, read_study, study_delay
from waypointctl.studies.flights import FlyCase
from waypointctl.studies.results_file import RESULTS

PERIOD_S = 0.02
RTTS_S = (0.0, 0.4, 2.56)
CASES = grid(["here"], ["mission", "waypoint", "short_range_goal", "short_range_goal-continuous"], RTTS_S, range(2))


@pytest.fixture(scope="module")
def still(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> LoadedPolicy:
    return make_policy(tmp_path_factory.mktemp("policy") / "still", gain=0.0)


def study(folder: Path, policy: LoadedPolicy, **options: object) -> DelayStudy | None:
    arguments = {"cases": CASES, "fine": [], "folder": folder} | options
    return study_delay(policy, {"here": here()}, **arguments)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory, still: LoadedPolicy) -> tuple[Path, DelayStudy]:
    folder = tmp_path_factory.mktemp("study")
    found = study(folder, still)
    assert found is not None
    return folder, found


@pytest.mark.parametrize(("autonomy", "trips"), [("mission", 1), ("waypoint", 3), ("short_range_goal", 3)])
def test_a_robot_that_is_there_takes_a_round_trip_for_each_command(
    found: tuple[Path, DelayStudy], autonomy: str, trips: int
) -> None:
    for cell in found[1].cells_of("here", autonomy):
        assert (cell.successes, cell.falls, cell.exchanges) == (2, 0, trips)
        assert cell.time_s is not None
        # A leg is judged after its first control period, and the robot looks at its receiver once in one.
        assert trips * cell.rtt_s < cell.time_s.value <= trips * cell.rtt_s + 2 * 3 * PERIOD_S


def test_it_has_not_walked_but_stood(found: tuple[Path, DelayStudy]) -> None:
    (cell,) = (one for one in found[1].cells_of("here", "waypoint") if one.rtt_s == 2.56)
    assert cell.distance_m is not None
    assert cell.standing_share is not None
    assert cell.distance_m.value < 0.1
    assert cell.standing_share.value > 0.9


def test_the_claims_hold_on_the_link_alone(found: tuple[Path, DelayStudy]) -> None:
    findings = {one.claim.partition(" ")[0].strip(","): one.finding for one in found[1].claims}
    assert findings["waypoint"] == "holds"
    assert findings["short_range_goal"] == "holds"


def test_what_comes_of_it_is_in_the_folder(found: tuple[Path, DelayStudy]) -> None:
    folder, study = found
    assert {path.name for path in folder.iterdir()} == {RESULTS, STUDY, TABLES, VALUES, PICTURE, ".lock"}
    assert read_study(folder / STUDY) == study
    assert len((folder / RESULTS).read_bytes().splitlines()) == len(CASES) + 1


def test_a_pickled_function_flies_the_same(still: LoadedPolicy) -> None:
    fly_case = FlyCase({"here": here()}, still, 0.0)
    again = pickle.loads(pickle.dumps(fly_case))
    assert again(CASES[0], lambda: False) == fly_case(CASES[0], lambda: False)


@pytest.mark.slow
def test_flights_side_by_side_give_the_same_bytes(
    found: tuple[Path, DelayStudy], tmp_path: Path, still: LoadedPolicy
) -> None:
    study(tmp_path, still, processes=2)
    for name in (RESULTS, STUDY, TABLES, VALUES, PICTURE):
        ours, theirs = (hashlib.sha256((folder / name).read_bytes()).hexdigest() for folder in (tmp_path, found[0]))
        assert ours == theirs, name


def test_an_interrupted_study_goes_on_where_it_was(
    found: tuple[Path, DelayStudy], tmp_path: Path, still: LoadedPolicy
) -> None:
    seen: list[int] = []
    watch = {"progress": lambda flown, total: seen.append(flown), "interrupted": lambda: len(seen) > 5}
    assert study(tmp_path, still, **watch) is None
    assert not (tmp_path / STUDY).exists()
    assert seen == [0, 1, 2, 3, 4, 5]
    seen.clear()
    assert study(tmp_path, still, progress=lambda flown, total: seen.append(flown)) == found[1]
    assert seen == list(range(5, len(CASES) + 1))
    assert (tmp_path / RESULTS).read_bytes() == (found[0] / RESULTS).read_bytes()


def test_a_finished_study_flies_nothing_again_and_takes_more_in(tmp_path: Path, still: LoadedPolicy) -> None:
    few = grid(["here"], ["mission"], [0.0], [1])
    more = grid(["here"], ["mission"], [0.0, 0.4], [1, 2])
    study(tmp_path, still, cases=few)
    seen: list[tuple[int, int]] = []
    assert study(tmp_path, still, cases=few, progress=lambda *both: seen.append(both)) is not None
    larger = study(tmp_path, still, cases=more, progress=lambda *both: seen.append(both))
    assert larger is not None
    assert [cell.flights for cell in larger.cells] == [2, 2]
    assert seen == [(1, 1), (1, 4), (2, 4), (3, 4), (4, 4)]


def test_an_interruption_in_the_middle_of_a_flight_leaves_it_out(still: LoadedPolicy) -> None:
    asked = iter([False] * 10 + [True] * 10)
    fly_case = FlyCase({"here": here()}, still, 0.0)
    assert fly_case(DelayCase("here", "mission", 10.0, 0), lambda: next(asked)) is None


def test_logs_are_kept_that_tell_the_same_story(tmp_path: Path, still: LoadedPolicy) -> None:
    cases = [case for case in CASES if (case.autonomy, case.rtt_s) == ("short_range_goal", 2.56)]
    found = study(tmp_path, still, cases=cases, keep_logs=True)
    assert found is not None
    logs = sorted((tmp_path / LOGS).iterdir())
    assert [log.name for log in logs] == [f"here-short_range_goal-2.56s-{seed}.mcap" for seed in (0, 1)]
    summaries = [FlightLog.open(log).summary for log in logs]
    assert [summary.outcome for summary in summaries] == ["success", "success"]
    assert found.cells[0].time_s is not None
    assert sum(summary.ended_ns for summary in summaries) / 2e9 == pytest.approx(found.cells[0].time_s.value)


def test_a_policy_for_another_robot_flies_nothing(tmp_path: Path, make_policy: Callable[..., LoadedPolicy]) -> None:
    other = make_policy(tmp_path / "rover", robot="rover")
    with pytest.raises(PolicyError, match="made for the robot 'rover'"):
        study(tmp_path / "study", other)
    assert not (tmp_path / "study").exists()
