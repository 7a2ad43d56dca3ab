"""The parts of a flight's picture: labels that cover no other, lines across gaps, time, home, zones, the link."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Annotation

from tests.replay.hand_made import FAR, NEAR, STEP_NS, ack, event, flight, frame, stage, state
from waypointctl.log.header import ContactWindows, MissionSetting
from waypointctl.log.messages import (
    Ack,
    Clock,
    Command,
    CommandKind,
    DeliveryOutcome,
    EventKind,
    LinkRecord,
    Message,
    PlannedWaypoint,
    Stage,
    Telemetry,
)
from waypointctl.mission.onboard import Zone
from waypointctl.replay.picture.page import HEIGHT, WIDTH, _draw_parts, _drawn, _wrapped
from waypointctl.replay.picture.time_axis import _along, _knots, _ticks, time_text, waits_in
from waypointctl.replay.summary import FlightSummary
from waypointctl.replay.summary_builder import summarize
from waypointctl.units import NS_PER_S, ns

SETTING = MissionSetting(
    home=replace(NEAR, name="home", x_m=0.0, y_m=0.0),
    zones=(
        Zone("site", True, ((-3.0, -3.0), (9.0, -3.0), (9.0, 4.0), (-3.0, 4.0))),
        Zone("a pit with a long name that goes on and on", False, ((3.0, 1.0), (4.0, 1.0), (4.0, 2.0))),
    ),
    up=ContactWindows(np.array([0]), np.array([2 * NS_PER_S]), 4 * NS_PER_S),
    down=ContactWindows(np.array([0]), np.array([3 * NS_PER_S])),
)


def parts(summary: FlightSummary) -> Figure:
    figure = Figure(figsize=(WIDTH / 100, HEIGHT / 100), dpi=100)
    FigureCanvasAgg(figure)
    _draw_parts(figure, summary)
    figure.draw_without_rendering()
    return figure


def legend(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.get_legend().get_texts()]  # type: ignore[union-attr]


def legends(figure: Figure) -> list[str]:
    return [text for axes in figure.axes for text in legend(axes)]


def names(figure: Figure, part: int) -> list[str]:
    return [text.get_text() for text in figure.axes[part].texts if text.get_text()]


def assert_no_label_covers_another(figure: Figure) -> None:
    for axes in figure.axes:
        boxes = [text.get_window_extent() for text in axes.texts if text.get_text()]
        for one, other in combinations(boxes, 2):
            assert not (one.x0 < other.x1 and other.x0 < one.x1 and one.y0 < other.y1 and other.y0 < one.y1)
        for box in boxes:
            assert 0 <= box.x0 <= box.x1 <= WIDTH
            assert 0 <= box.y0 <= box.y1 <= HEIGHT


def many_waypoints(count: int, apart_m: float, name: str) -> tuple[PlannedWaypoint, ...]:
    return tuple(replace(NEAR, index=n, name=f"{name}{n}", x_m=n * apart_m) for n in range(count))


def commands(count: int, apart_s: float) -> Iterable[Message]:
    for number in range(101, count + 101):
        sent_s = (number - 100) * apart_s
        yield stage(sent_s, Stage.QUEUED, Clock.OPERATOR, command_id=number)
        text = f"command {number} sent: hold"
        yield event(sent_s, EventKind.COMMAND_SENT, text, Clock.OPERATOR, command_id=number)
        yield Command(number, CommandKind.HOLD, (), "", ns(sent_s), ns(sent_s + 0.3))
        for which in (Stage.STARTED, Stage.COMPLETED):
            yield Ack(number, which, "", ns(sent_s + 0.3), ns(sent_s + 0.6))


@pytest.mark.parametrize(
    ("count", "apart_m", "name"),
    [
        (40, 3.0, "WP"),
        (20, 0.0, "WP"),
        (20, 0.5, "a name as long as names can be, and longer than any label "),
        (8, 1.0, "近いところ"),
    ],
)
def test_no_label_covers_another_however_many_waypoints_there_are(count: int, apart_m: float, name: str) -> None:
    waypoints = many_waypoints(count, apart_m, name)
    reached = [event(1 + n / 20, EventKind.WAYPOINT_REACHED, "", waypoint=n) for n in range(count)]
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from")
        assert_no_label_covers_another(parts(summarize([*flight(), *reached], waypoints, SETTING)))


@pytest.mark.parametrize(("count", "apart_s"), [(2, 0.2), (20, 0.2), (40, 0.0)])
def test_no_label_covers_another_however_many_commands_there_are(count: int, apart_s: float) -> None:
    figure = parts(summarize([*commands(count, apart_s), *flight()], (NEAR, FAR), SETTING))
    assert_no_label_covers_another(figure)
    if count <= 2 and apart_s:
        assert {"101: hold", "101 completed"} <= set(names(figure, 2))


def test_what_went_wrong_is_labelled_first_and_alone_where_there_are_hundreds() -> None:
    failed: list[Message] = [stage(1, Stage.FAILED, command_id=150), Ack(150, Stage.FAILED, "", ns(1.0), ns(1.5))]
    figure = parts(summarize([*commands(200, 0.02), *failed, *flight()], (NEAR, FAR)))
    assert {name.partition(":")[0].partition(" ")[0] for name in names(figure, 2)} <= {"150", "1"}
    assert any("150 failed" in name for name in names(figure, 2))
    assert "201 commands" in figure.axes[2].get_title(loc="left") + figure.axes[2].get_title()


def test_the_speed_line_is_at_zero_while_physics_sleeps_and_broken_where_states_are_missing() -> None:
    walking = [state(n, n * 1.0, 0.0, 2.0) for n in range(20)]
    after_rest = [replace(one, time_ns=one.time_ns + 1000 * NS_PER_S) for one in walking]
    rest = (event(10, EventKind.REST_STARTED, ""), event(1000, EventKind.REST_ENDED, ""))
    for events, between in ((rest, 0.0), ((), np.nan)):
        summary = summarize([*walking, *events, *after_rest])
        track, mean_mps = _drawn(summary.truth, summary.resting)
        inside = (track.time_ns == 19 * STEP_NS) | (track.time_ns == 1000 * NS_PER_S)
        np.testing.assert_array_equal(track.time_ns[inside], np.repeat([19 * STEP_NS, 1000 * NS_PER_S], 2))
        np.testing.assert_array_equal(track.speed_mps[inside], [2.0, between, between, 2.0])
        np.testing.assert_array_equal(mean_mps[inside], [2.0, between, between, 2.0])
        assert len(track) == 42


def test_a_track_without_gaps_is_drawn_as_it_is() -> None:
    summary = summarize(flight())
    track, mean_mps = _drawn(summary.truth, ())
    np.testing.assert_array_equal(track.speed_mps, summary.truth.speed_mps)
    assert len(mean_mps) == len(track) == 11


DAY_S = 86_400


def slow() -> FlightSummary:
    """Return a flight whose robot rests for five days, twice."""
    walking = [state(n, 0.0, 0.0, 1.0) for n in range(20)]
    later = [replace(one, time_ns=one.time_ns + 5 * DAY_S * NS_PER_S) for one in walking]
    end = event(10 * DAY_S, EventKind.MISSION_ENDED, "success: 0 of 0", Clock.OPERATOR)
    beacons = [frame(n, n * 3600.0, 0.0, ()) for n in range(230)]
    return summarize([*walking, *later, *beacons, end])


def test_long_waits_are_drawn_shorter() -> None:
    first, second = waits_in(slow())
    assert (first.begin_s, first.end_s) == (9.5, 5 * DAY_S)
    assert (second.begin_s, second.end_s) == (5 * DAY_S + 9.5, 10 * DAY_S)
    figure = parts(slow())
    begin, end = (figure.axes[1].transData.transform((at, 0.0))[0] for at in (5 * DAY_S, 5 * DAY_S + 9.5))
    assert end - begin > 100, "the ten seconds in which the robot walks can be seen"
    assert "waits" in figure.axes[2].get_xlabel()
    assert waits_in(summarize(flight())) == ()
    assert parts(summarize(flight())).axes[2].get_xlabel() == "simulation time [s]"


@given(st.floats(-1e3, 1e7))
def test_the_axis_of_time_goes_both_ways(time_s: float) -> None:
    true_s, drawn_s = _knots(waits_in(slow()), 10.0 * DAY_S)
    there = _along(np.array([time_s]), true_s, drawn_s)
    assert _along(there, drawn_s, true_s)[0] == pytest.approx(time_s, abs=1e-3)


def test_ticks_are_few_and_tell_the_time() -> None:
    ticks, told = _ticks(waits_in(slow()), 10.0 * DAY_S, 4.0)
    assert ticks == sorted(ticks)
    assert told == ["0", "5", "5 d", "+5", "10 d"]


@pytest.mark.parametrize(
    ("time_s", "text"),
    [(0.0, "0.00 s"), (432.1, "432.10 s"), (3600.0, "1 h"), (3725.5, "1 h 2 min 5.5 s"), (432002.62, "5 d 2.62 s")],
)
def test_times_as_people_say_them(time_s: float, text: str) -> None:
    assert time_text(time_s) == text


def lost(way: str, time_s: float) -> LinkRecord:
    return LinkRecord(ns(time_s), way, "telemetry", 1, 10, ns(time_s), (), DeliveryOutcome.LOST)


def test_what_there_is_of_home_zones_and_link_is_drawn_and_named() -> None:
    home = (event(4, EventKind.RETURN_STARTED, "returning home: timeout"), event(4.8, EventKind.HOME_REACHED, "home"))
    lost_spans = event(3, EventKind.LINK_LOST, "link lost")
    summary = summarize(
        [*flight(), *home, lost_spans, lost("up", 1), lost("down", 2), lost("down", 3)], (NEAR, FAR), SETTING
    )
    figure = parts(summary)
    assert {"home", "way home", "3 not delivered", "hollow: no contact down", "no contact"} <= set(legends(figure))
    assert "link lost, on board" in legends(figure)
    assert {"home", "keep-in site"} <= set(names(figure, 0))
    assert {"way home", "home reached"} <= set(names(figure, 1))
    plain = legends(parts(summarize(flight(), (NEAR, FAR))))
    assert not {"home", "way home", "no contact", "link lost, on board"} & set(plain)
    assert not any("not delivered" in text for text in plain)


def test_a_command_that_was_lost_is_told_from_one_under_way() -> None:
    sent = event(1, EventKind.COMMAND_SENT, "command 2 sent: hold", Clock.OPERATOR, command_id=2)
    queued = stage(1, Stage.QUEUED, Clock.OPERATOR, command_id=2)
    under_way = parts(summarize([*flight(), sent, queued]))
    assert "2: hold (under way)" in names(under_way, 2)
    is_lost = parts(summarize([*flight(), sent, queued, stage(1, Stage.LOST, Clock.LINK, command_id=2), lost("up", 1)]))
    assert "2: hold (not delivered)" in names(is_lost, 2)


def test_an_arrow_begins_with_the_sending_that_arrived() -> None:
    again: list[Message] = [
        stage(0, Stage.QUEUED, Clock.OPERATOR),
        stage(3, Stage.QUEUED, Clock.OPERATOR, attempt=2),
        Command(1, CommandKind.GO_TO, (NEAR,), "abort", ns(3.0), ns(4.0), attempt=2),
        ack(Stage.RECEIVED, 4.0),
    ]
    arrows = [
        text for text in parts(summarize(again)).axes[2].texts if isinstance(text, Annotation) and text.arrow_patch
    ]
    assert (arrows[0].xyann[0], arrows[0].xy[0]) == (3.0, 4.0)


@pytest.mark.parametrize("far_m", [0.0, 1e4])
def test_a_metre_is_as_long_along_both_axes(far_m: float) -> None:
    axes = parts(summarize(flight(), (NEAR, replace(FAR, x_m=far_m)), SETTING)).axes[0]
    (x0, y0), (x1, y1) = axes.transData.transform([(0.0, 0.0), (1.0, 1.0)])
    assert x1 - x0 == pytest.approx(y1 - y0)


def test_a_commanded_place_that_is_no_waypoint_is_marked_and_named() -> None:
    place = PlannedWaypoint(-1, "(3, 4)", 3.0, 4.0, "radius", 0.5, NS_PER_S, 0)
    console = [*flight(), Command(2, CommandKind.GO_TO, (place,), "", 0, ns(1.0))]
    axes = parts(summarize(console, (NEAR, FAR))).axes[0]
    (marks,) = (line for line in axes.lines if line.get_label() == "commanded place")
    assert (list(marks.get_xdata()), list(marks.get_ydata())) == ([3.0], [4.0])  # type: ignore[arg-type]
    assert "(3, 4)" in {text.get_text() for text in axes.texts}
    assert "commanded place" not in legends(parts(summarize(flight(), (NEAR, FAR))))


def test_legends_name_only_what_is_drawn() -> None:
    path, _, messages = parts(summarize([], (NEAR, FAR))).axes
    assert path.get_legend() is None
    assert legend(messages) == []
    lost_spans = [message for message in flight() if not isinstance(message, (Ack, Telemetry))]
    assert legend(parts(summarize(lost_spans, (NEAR, FAR))).axes[2]) == ["command", "moving", "reached"]


@pytest.mark.parametrize("count", [1, 30, 200])
def test_a_long_headline_is_broken_between_words(count: int) -> None:
    text = _wrapped("failure: " + "the robot is at (4.19, -11.25) m; " * count)
    lines = text.split("\n")
    assert len(lines) == min(count, 2)
    assert max(map(len, lines)) <= 170
    whole = {"failure:", "the", "robot", "is", "at", "(4.19,", "-11.25)", "m;", "\N{HORIZONTAL ELLIPSIS}"}
    assert set(text.split()) <= whole
