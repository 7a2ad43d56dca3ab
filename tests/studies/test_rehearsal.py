"""Rehearsals of robots that stand where they shall go: what becomes of them is what becomes of the link."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from waypointctl.errors import PolicyError
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Mission
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.studies.rehearsal import Rehearsal, RehearsedFlight, rehearsal_seed, rehearse

HERE = "name: here\npolicy: p\nseed: 5\nwaypoints: [{name: a, position: [0 m, 0 m]}, [0 m, 0.1 m]]\n"


@pytest.fixture(scope="module")
def still(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> LoadedPolicy:
    return make_policy(tmp_path_factory.mktemp("policy") / "still", gain=0.0)


def mission(more: str = "") -> Mission:
    return parse_mission(f"{HERE}{more}".encode(), "m.yaml")


def rehearsed(policy: LoadedPolicy, *missions: Mission, flights: int) -> list[list[Rehearsal]]:
    found = rehearse(
        [(each, policy) for each in missions],
        lambda each: [each.autonomy],
        flights,
        1,
        lambda ended, total: None,
        lambda: False,
    )
    assert found is not None
    return found


def test_the_seeds_are_the_missions_own_and_others_by_index() -> None:
    seeds = [rehearsal_seed(mission(), index) for index in range(50)]
    assert seeds[0] == 5
    assert len(set(seeds)) == 50
    assert max(seeds) < 2**63


def test_successes_failures_and_losses_are_told_by_mission(still: LoadedPolicy) -> None:
    lossy = mission("link: {up: {delay: 1 s, loss: 50 %}, down: {delay: 1 s}}\ncommands: {retries: 0}\n")
    away = mission("defaults: {tolerance: 5 cm, timeout: 0.2 s}\nstart_at: WP2\n")
    (lost,), (failed,) = rehearsed(still, lossy, away, flights=8)
    assert 0 < lost.successes < 8
    assert lost.time_s is not None
    assert 2.0 < lost.time_s[1] <= lost.time_s[0] <= lost.time_s[2] < 2.3
    assert lost.undelivered == [(("up", "command", "lost"), 8 - lost.successes, 8 - lost.successes)]
    assert sum(flights for *_, flights, _ in lost.failures) == 8 - lost.successes
    (cause, waypoint, flights, seed), *_ = failed.failures
    assert (cause, waypoint, flights, seed) == ("timeout", "WP2", 8, 5)
    assert failed.time_s is None
    assert failed.record()["each"][0]["seed"] == 5


def test_the_most_frequent_failure_is_first() -> None:
    def flight(cause: str, waypoint: str, seed: int) -> RehearsedFlight:
        outcome = "failure" if cause else "success"
        return RehearsedFlight(seed, outcome, cause, waypoint, 1.0, 0, {})  # type: ignore[arg-type]

    flights = (flight("", "", 1), flight("fall", "a", 2), flight("fall", "b", 3), flight("fall", "b", 4))
    assert Rehearsal("mission", flights).failures == [("fall", "b", 2, 3), ("fall", "a", 1, 2)]


def test_a_policy_for_another_robot_is_refused(tmp_path: Path, make_policy: Callable[..., LoadedPolicy]) -> None:
    other = make_policy(tmp_path / "rover", robot="rover")
    with pytest.raises(PolicyError):
        rehearsed(other, mission(), flights=1)
