"""What a mission fixes: contact windows, zones, home."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from hypothesis import given
from hypothesis import strategies as st

from waypointctl.flight.fly import fly
from waypointctl.flight.header import setting_of
from waypointctl.flight.link.contacts import Contacts, Window
from waypointctl.log.header import ContactWindows
from waypointctl.log.reader import open_log
from waypointctl.mission.files import MissionFile, parse_mission
from waypointctl.mission.onboard import CIRCLE_CORNERS
from waypointctl.policy.bundle import LoadedPolicy

HEAD = "name: n\npolicy: ./p\nwaypoints: [[6 m, 0 m]]\n"
FAR = 400


@st.composite
def windows(draw: st.DrawFn) -> ContactWindows:
    count = draw(st.integers(1, 4))
    begins, lasts = (draw(st.lists(st.integers(0, 9), min_size=count, max_size=count)) for _ in range(2))
    edges = np.cumsum([step for begin, last in zip(begins, lasts, strict=True) for step in (begin, last + 1)])
    period = draw(st.sampled_from([0, int(edges[-1]), int(edges[-1]) + 5]))
    return ContactWindows(edges[::2], edges[1::2], period)


def contact(shown: ContactWindows) -> list[bool]:
    """Return whether there is contact at each of FAR times, by the definition of it."""
    pairs = list(zip(shown.begin_ns.tolist(), shown.end_ns.tolist(), strict=True))
    within = (at % shown.period_ns if shown.period_ns else at for at in range(FAR))
    return [any(begin <= at < end for begin, end in pairs) for at in within]


@given(windows(), st.integers(0, FAR // 2))
def test_contact_is_as_it_is_defined_and_as_the_link_has_it(shown: ContactWindows, now_ns: int) -> None:
    expected = contact(shown)
    assert shown.is_open(np.arange(FAR)).tolist() == expected
    pairs = [Window(begin, end) for begin, end in zip(shown.begin_ns.tolist(), shown.end_ns.tolist(), strict=True)]
    link = Contacts(pairs, shown.period_ns)
    assert all(link.next_open_ns(at) == at for at in range(FAR) if expected[at])
    change_ns = next((at for at in range(now_ns, FAR) if expected[at] != expected[now_ns]), None)
    assert shown.change_ns(now_ns) == change_ns


@given(windows(), st.integers(1, FAR))
def test_closed_spans_are_where_there_is_no_contact(shown: ContactWindows, until_ns: int) -> None:
    spans = shown.closed(until_ns, 10_000)
    assert spans is not None
    closed = np.zeros(until_ns, np.bool_)
    for begin, end in spans:
        assert 0 <= begin < end <= until_ns
        closed[begin:end] = True
    assert closed.tolist() == [not is_open for is_open in contact(shown)[:until_ns]]
    assert shown.closed(until_ns, 0) is None


def test_windows_that_come_again_for_ever_are_not_written_out() -> None:
    shown = ContactWindows(np.array([0]), np.array([1]), 2)
    assert shown.closed(10**15, 1000) is None
    assert shown.change_ns(10**15) == 10**15 + 1


def test_a_link_that_is_always_there_has_no_windows() -> None:
    setting = setting_of(parse_mission(HEAD.encode(), "m.yaml"))
    assert (setting.up, setting.down, setting.zones) == (None, None, ())


def test_each_way_has_its_windows() -> None:
    link = "link: {up: {windows: [{from: 1 s, to: 2 s}], windows_period: 5 s}}\n"
    setting = setting_of(parse_mission((HEAD + link).encode(), "m.yaml"))
    assert setting.down is None
    assert setting.up is not None
    assert (setting.up.begin_ns.tolist(), setting.up.end_ns.tolist()) == ([10**9], [2 * 10**9])
    assert setting.up.period_ns == 5 * 10**9


@pytest.mark.parametrize(
    ("more", "shown"),
    [
        ("", False),
        ("on_failure: return_home\n", True),
        ("onboard: {on_failure: {retry: 1, then: return_home}}\n", True),
        ("onboard: {link_loss: {after: 3 s, do: return_home}}\n", True),
        ("onboard: {geofence: {keep_in: [{center: [0 m, 0 m], radius: 9 m}], do: return_home}}\n", True),
        ("onboard: {geofence: {do: return_home}}\n", False),  # there is no fence
        ("onboard: {home: {position: [2 m, 1 m]}}\n", True),
        ("schedule: [{at: 3 s, do: return_home}]\n", True),
        ("schedule: [{at: 3 s, do: hold}]\n", False),
    ],
)
def test_home_is_shown_where_the_robot_may_go_there_or_has_gone(more: str, shown: bool) -> None:
    setting = setting_of(parse_mission((HEAD + more).encode(), "m.yaml"))
    assert (setting.home_to_show(has_returned=False) is not None) is shown
    home = setting.home_to_show(has_returned=True)
    assert home is not None
    assert (home.x_m, home.y_m) == ((2.0, 1.0) if "position: [2" in more else (0.0, 0.0))


def test_zones_have_their_names_and_outlines() -> None:
    fence = (
        "onboard: {geofence: {keep_in: [{corners: [[-4, -4], [9, -4], [9, 9]]}], "
        "keep_out: [{name: pit, center: [3 m, 4 m], radius: 2 m}]}}\n"
    )
    site, pit = setting_of(parse_mission((HEAD + fence).encode(), "m.yaml")).zones
    assert (site.label, site.outline_m) == ("keep-in 1", ((-4.0, -4.0), (9.0, -4.0), (9.0, 9.0)))
    assert (pit.label, len(pit.outline_m)) == ("keep-out pit", CIRCLE_CORNERS)
    assert np.hypot(*(np.array(pit.outline_m) - (3, 4)).T) == pytest.approx(2.0)


def test_the_log_of_a_flight_draws_what_its_mission_fixes(
    tmp_path: Path, make_policy: Callable[..., LoadedPolicy]
) -> None:
    more = (
        "onboard: {home: {position: [2 m, 1 m]}, "
        "geofence: {keep_out: [{name: pit, center: [3 m, 4 m], radius: 2 m}]}}\n"
        "link: {windows: [{from: 0 s, to: 20 s}]}\nexpect: {max_time: 1 s}\n"
    )
    source = (HEAD + more).encode()
    file = MissionFile(parse_mission(source, "m.yaml"), source, tmp_path / "m.yaml")
    fly(file, make_policy(tmp_path / "p", gain=0.0), log=tmp_path / "f.mcap")
    log = open_log(tmp_path / "f.mcap")
    first = next(raw.data for topic, raw in log.raw_messages() if topic == "/scene")
    shown = {entity.id: [text.text for text in entity.texts] for entity in SceneUpdate.FromString(first).entities}
    assert shown["zone 0"] == ["keep-out pit"]
    assert shown["home"] == ["home"]
    assert shown["link"] == ["link up: open until 20.00 s\nlink down: open until 20.00 s"]
