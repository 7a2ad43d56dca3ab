"""A study varies a mission's delay and nothing else of its link, its operator and its rules; or it refuses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.studies.standing import here
from waypointctl.errors import InputError
from waypointctl.flight.fly import fly
from waypointctl.mission.files import MissionFile, dump_mission, load_mission, parse_mission
from waypointctl.mission.link import Link
from waypointctl.mission.mission import Mission
from waypointctl.mission.presets import PRESETS
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.studies.case import (
    AUTONOMIES,
    CONTINUOUS,
    DelayCase,
    least_round_trip_s,
    load_route,
    mission_of,
    refuse_what_is_not_kept,
    with_round_trip,
)
from waypointctl.studies.delay import route_digest

ROOT = Path(__file__).parents[2]
RTTS_S = (0.0, 0.4, 8.0, 40.0)
HARSH = (
    "{delay: 4 s, jitter: 500 ms, loss: 15 %, rate: 9.6 kbit/s, queue: 16 KiB, "
    "windows: [{from: 0 s, to: 40 s}, {from: 70 s, to: 110 s}, {from: 150 s, to: 9000 s}]}"
)
LINKS = {
    "harsh": HARSH,
    "bursts": "{delay: 1 s, loss: {p: 10 %, r: 30 %}, duplicate: 5 %, keep_order: false}",
    "normal jitter": "{delay: 1 s, jitter: 300 ms, jitter_distribution: normal}",
    "windows that come again": "{windows: [{from: 1 s, to: 5 s}], windows_period: 20 s}",
    "three times as long down": "{up: {delay: 1 s}, down: {delay: 3 s, rate: 64 kbit/s}}",
    "only up": "{up: {delay: 2 s, loss: 5 %}}",
    **{name: f"{{preset: {name}, loss: 1 %}}" for name in PRESETS},
}
REST = (
    "commands: {retries: 5, margin: 2 s}\noperator: {think: 1 s, heartbeat: 5 s, lookahead: 2 m}\n"
    "telemetry: {rate: 2 Hz, beacon: 30 s}\n"
    "onboard: {on_failure: {retry: 1, then: skip}, link_loss: {after: 30 s, do: hold}, stopped_tolerance: 20 cm}\n"
)


def route(link: str = "{}", more: str = REST) -> Mission:
    text = f"name: r\npolicy: p\nwaypoints: [[4, 0], [8, 2]]\nlink: {link}\n{more}"
    return parse_mission(text.encode(), "r.yaml")


def without_delays(link: Link) -> dict[str, object]:
    """Return all that a study keeps of a link."""
    return {
        name: {key: value for key, value in dump.items() if key not in ("delay_s", "delay_table")}
        for name, dump in link.model_dump().items()
        if name != "preset"
    }


@pytest.mark.parametrize("text", LINKS.values(), ids=LINKS)
@pytest.mark.parametrize("autonomy", ["mission", CONTINUOUS.name])
def test_everything_but_the_delay_stays(text: str, autonomy: str) -> None:
    mission = route(text)
    for rtt_s in (
        one for one in (*RTTS_S, least_round_trip_s(mission.link)) if one >= least_round_trip_s(mission.link)
    ):
        varied = mission_of(mission, DelayCase("r", autonomy, rtt_s, 3))
        up_s, down_s = varied.link.up.delay_s, varied.link.down.delay_s
        assert up_s + down_s == pytest.approx(rtt_s)
        assert without_delays(varied.link) == without_delays(mission.link)
        kept = ("commands", "telemetry", "onboard", "defaults", "start", "robot", "repeat")
        assert all(getattr(varied, name) == getattr(mission, name) for name in kept)
        changed = {"steering": varied.operator.steering}
        assert varied.operator == mission.operator.model_copy(update=changed)
        assert parse_mission(dump_mission(varied).encode(), "again.yaml") == varied, "a log can carry it"


def test_a_round_trip_is_shared_as_the_mission_shares_it() -> None:
    shared = {text: with_round_trip(route(text).link, 8.0) for text in LINKS.values()}
    delays = {text: (link.up.delay_s, link.down.delay_s) for text, link in shared.items()}
    assert delays[LINKS["three times as long down"]] == (2.0, 6.0)
    assert delays[LINKS["only up"]] == (8.0, 0.0)
    assert delays[LINKS["windows that come again"]] == delays[LINKS["harsh"]] == (4.0, 4.0)


def test_a_contact_plan_keeps_its_windows_and_rates_and_files() -> None:
    mission = load_mission(ROOT / "missions" / "contact-plan.yaml").mission
    for rtt_s in (0.0, 3.0):
        varied = mission_of(mission, DelayCase("r", "waypoint", rtt_s, 3))
        assert without_delays(varied.link) == without_delays(mission.link)
        assert varied.files == mission.files
        assert not varied.link.up.has_own_delay or varied.link.up.delay_table is not None
        rows = [way.delay_table for way in (varied.link.up, varied.link.down)]
        assert [[row.delay_s for row in table or ()] for table in rows] == [[rtt_s / 2], [rtt_s / 2]]


@pytest.mark.parametrize(
    ("link", "more", "said"),
    [
        ("{delay_table: [{at: 0 s, delay: 1 s}]}", "", ["link.up.delay_table", "link.down.delay_table"]),
        ("{}", "schedule: [{at: 1 s, do: hold}, {at: 2 s, do: resume}]\n", ["schedule"]),
        (
            "{down: {delay_table: [{at: 0 s, delay: 1 s}]}}",
            "schedule: [{at: 1 s, do: hold}, {at: 2 s, do: resume}]\n",
            ["link.down.delay_table", "schedule"],
        ),
    ],
)
def test_what_cannot_stay_is_refused_all_of_it(link: str, more: str, said: list[str]) -> None:
    file = MissionFile(route(link, more), b"", Path("mine.yaml"))
    with pytest.raises(InputError) as refused:
        refuse_what_is_not_kept({"r": file})
    assert refused.value.where == "mine.yaml"
    assert all(name in refused.value.problem for name in said)
    assert "copy of the mission" in (refused.value.hint or "")


def test_a_round_trip_that_is_shorter_than_the_jitter_allows_is_refused() -> None:
    file = MissionFile(route("{up: {delay: 1 s, jitter: 500 ms}, down: {delay: 3 s}}"), b"", Path("mine.yaml"))
    assert least_round_trip_s(file.mission.link) == 2.0
    refuse_what_is_not_kept({"r": file}, [2.0, 5.0])
    with pytest.raises(InputError, match=r"--rtt: 1 s is less than 2 s"):
        refuse_what_is_not_kept({"r": file}, [1.0, 5.0])


@pytest.mark.parametrize("name", ["two-point", "ten-point", "short"])
@pytest.mark.parametrize("autonomy", AUTONOMIES)
def test_the_shipped_routes_have_nothing_but_a_delay(name: str, autonomy: str) -> None:
    """What docs/delay.md shows was flown over a link of two equal delays and nothing else."""
    mission = load_route(name).mission
    refuse_what_is_not_kept({name: load_route(name)}, RTTS_S)
    varied = mission_of(mission, DelayCase(name, autonomy, 2.56, 7))
    assert varied.link == Link.model_validate({"delay_s": 1.28})
    assert varied.operator.think_s == 0.0
    assert varied.expect.max_time_s is not None
    limits_s = sum(leg.timeout_s + leg.hold_s for leg in varied.legs())
    allowances_s = {leg.timeout_s - own.timeout_s for leg, own in zip(varied.legs(), mission.legs(), strict=True)}
    (allowance_s,) = allowances_s
    assert allowance_s / 2.56 == pytest.approx(round(allowance_s / 2.56)), "a whole number of round trips"
    assert varied.expect.max_time_s == pytest.approx(limits_s + allowance_s)


@settings(max_examples=50, deadline=None)
@given(st.floats(0, 100), st.floats(0, 100), st.floats(0, 1), st.floats(0, 50))
def test_every_round_trip_from_the_least_on_gives_a_link_that_can_be(
    up_s: float, down_s: float, part: float, more_s: float
) -> None:
    link = Link.model_validate({"up": {"delay_s": up_s, "jitter_s": up_s * part}, "down": {"delay_s": down_s}})
    varied = with_round_trip(link, least_round_trip_s(link) + more_s)
    assert Link.model_validate(varied.model_dump(exclude={"preset"})) == varied


def test_a_link_makes_a_difference(tmp_path: Path, make_policy: Callable[..., LoadedPolicy]) -> None:
    still = make_policy(tmp_path / "still", gain=0.0)
    plain, harsh = here().mission, here().mission
    harsh = harsh.model_copy(update={"link": route(HARSH).link})
    case = DelayCase("here", "waypoint", 8.0, 1)
    flown = [fly(mission_of(one, case), still, lambda _: None) for one in (plain, harsh)]
    assert [one.outcome for one in flown] == ["success", "success"]
    assert flown[1].sim_time_ns > flown[0].sim_time_ns


def test_files_that_a_route_refers_to_are_part_of_it() -> None:
    file = load_route(str(ROOT / "missions" / "contact-plan.yaml"))
    other = replace(file, mission=file.mission.with_files(dict.fromkeys(file.mission.files, b"other")))
    assert route_digest(file) != route_digest(other)
