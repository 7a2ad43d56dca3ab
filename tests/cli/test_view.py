from __future__ import annotations

import io
import re
import time
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console
from rich.text import Text

from tests.replay.hand_made import FAR, NEAR, flight, stage
from waypointctl.cli.tui.canvas import Canvas
from waypointctl.cli.tui.chart import Scene, draw_map
from waypointctl.cli.tui.formatting import happening, size
from waypointctl.cli.tui.playback import Pace
from waypointctl.cli.tui.screens import PERIOD_S, LiveView, sizes
from waypointctl.cli.tui.tables import command_table, waypoint_table
from waypointctl.log.messages import Clock, CommandStage, FloatArray, Message, Severity, Stage, State
from waypointctl.replay.legs import WaypointStatus, WaypointSummary
from waypointctl.replay.summary_builder import summarize
from waypointctl.replay.track import Track
from waypointctl.units import NS_PER_S


def plain(rows: list[Text]) -> list[str]:
    return [row.plain for row in rows]


def test_dots_are_braille() -> None:
    canvas = Canvas(2, 1)
    # The corners of the first cell (dots 1, 4, 7 and 8 of braille), nothing in the second.
    canvas.dots(np.array([0.0, 1.0, 0.0, 1.9]), np.array([0.0, 0.0, 3.0, 3.9]), "red")
    assert plain(canvas.rows()) == ["\N{BRAILLE PATTERN DOTS-1478} "]
    assert plain(canvas.rows(ascii_only=True)) == [". "]


def test_what_is_outside_is_left_out() -> None:
    canvas = Canvas(1, 1)
    canvas.dots(np.array([-0.1, 2.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0, 4.0]), "red")
    canvas.sign(50, 0, "x", "red")
    assert plain(canvas.rows()) == [" "]


def test_a_line_has_no_gap() -> None:
    canvas = Canvas(10, 5)
    canvas.polyline(np.array([0.5, 19.5]), np.array([0.5, 0.5]), "red")
    assert plain(canvas.rows())[0] == "\N{BRAILLE PATTERN DOTS-14}" * 10


def scene(fate: WaypointStatus = WaypointStatus.OPEN) -> Scene:
    waypoint = WaypointSummary(NEAR, fate, None, None, None, None)
    return Scene(track([0.0, 1.0], [0.0, 0.0]), (waypoint,), belief=(0.0, 0.0))


def track(x_m: list[float], y_m: list[float]) -> Track:
    """Return a way, a row a second."""
    time_ns = np.arange(len(x_m)) * NS_PER_S
    return Track(time_ns, time_ns, np.array(x_m), np.array(y_m), np.ones(len(x_m)))


def test_the_map_has_everything_and_fits() -> None:
    rows = plain(draw_map(scene(), 40, 10))
    assert len(rows) == 10
    assert all(len(row) <= 40 for row in rows)
    drawing = "\n".join(rows)
    assert "●" in drawing
    assert "◇" in drawing
    assert "near" in drawing
    # The map is at least 2 m high, in 9 lines of 4 dots: 18 dots a metre, so half a metre is 9 dots, 4 or 5 cells.
    assert re.match("├─{2,3}┤ 0.5 m  ", rows[-1])


def test_east_is_right_and_north_is_up() -> None:
    way = Scene(track([0.0, 4.0], [0.0, 4.0]), (), belief=(0.0, 4.0))
    rows = plain(draw_map(way, 40, 20))
    (robot,) = [(line, row.index("●")) for line, row in enumerate(rows[:-1]) if "●" in row]
    (belief,) = [(line, row.index("◇")) for line, row in enumerate(rows[:-1]) if "◇" in row]
    (start,) = [(line, row.index("+")) for line, row in enumerate(rows[:-1]) if "+" in row]
    assert robot[0] == belief[0] < start[0]
    assert start[1] == belief[1] < robot[1]
    # 4 m are as far across as up: a cell is two dots wide and four high.
    assert 2 * (robot[1] - start[1]) == pytest.approx(4 * (start[0] - robot[0]), abs=4)


def test_the_map_in_ascii() -> None:
    assert all(row.isascii() for row in plain(draw_map(scene(), 40, 10, ascii_only=True)))


@pytest.mark.parametrize("fate", list(WaypointStatus))
def test_a_waypoint_shows_its_fate(fate: WaypointStatus) -> None:
    styles = {span.style for row in draw_map(scene(fate), 40, 10) for span in row.spans}
    expected = {WaypointStatus.REACHED: "green", WaypointStatus.OPEN: "yellow"}.get(fate, "red")
    assert expected in styles


def test_an_empty_map() -> None:
    assert len(draw_map(Scene(track([], []), ()), 20, 5)) == 5


@pytest.mark.parametrize("place", [(np.nan, 0.0), (0.0, -np.inf), (1e300, 1e300)])
def test_what_is_nowhere_is_left_out_of_the_map(place: tuple[float, float]) -> None:
    nowhere = replace(NEAR, name="lost", x_m=place[0], y_m=place[1])
    lost = WaypointSummary(nowhere, WaypointStatus.OPEN, None, None, None, None)
    known = scene()
    shown = replace(known, waypoints=(*known.waypoints, lost), belief=place)
    assert plain(draw_map(shown, 40, 10)) == plain(draw_map(replace(known, belief=None), 40, 10))


def test_a_name_does_not_steer_the_terminal() -> None:
    waypoint = WaypointSummary(replace(NEAR, name="\x1b[2J"), WaypointStatus.OPEN, None, None, None, None)
    drawing = "".join(plain(draw_map(replace(scene(), waypoints=(waypoint,)), 40, 10)))
    assert r"\u001b[2J" in drawing
    assert "\x1b" not in drawing


@pytest.mark.parametrize("qpos", [np.full(7, np.nan), np.full(7, np.inf), np.full(7, 1e300), np.zeros(0)])
def test_the_view_goes_on_when_the_robot_is_nowhere(qpos: FloatArray) -> None:
    people = Console(file=io.StringIO(), force_terminal=True, width=100, height=30)
    view = LiveView(people, "hand", (NEAR, FAR))
    for message in flight():
        if isinstance(message, State) and message.step in (0, 5):
            view.flight(replace(message, qpos=qpos))
        else:
            view.flight(message)
        people.print(view.picture())
    assert view.flight.summary().states_off_map == 2


@pytest.mark.parametrize("width", [1, 20, 40, 67, 68, 80, 200])
@pytest.mark.parametrize("height", [1, 5, 10, 16, 24, 50])
@pytest.mark.parametrize("encoding", ["utf-8", "ascii"])
def test_the_view_fits_every_terminal(width: int, height: int, encoding: str) -> None:
    file = io.TextIOWrapper(io.BytesIO(), encoding=encoding, errors="replace")
    people = Console(file=file, force_terminal=True, width=width, height=height, markup=False)
    view = LiveView(people, "hand", (NEAR, FAR))
    for message in flight():
        view.flight(message)
    lines = people.render_lines(view.picture(), pad=False)
    assert height < 10 or len(lines) < height
    assert max(sum(len(segment.text) for segment in line) for line in lines) <= width
    people.print(view.picture())


def test_a_terminal_of_80_by_24_has_room_for_all_of_it() -> None:
    plan = sizes(80, 24)
    assert plan.side_by_side
    assert plan.map_lines >= 10
    assert plan.commands >= 2
    assert plan.happenings >= 3


def shown(upto: int | None = None, **options: object) -> str:
    people = Console(file=io.StringIO(), force_terminal=True, width=80, height=24, markup=False, **options)  # type: ignore[arg-type]
    view = LiveView(people, "hand", (NEAR, FAR))
    view._live.start()
    for message in list(flight())[:upto]:
        view(message)
    view.draw()
    with people.capture() as capture:
        people.print(view.picture())
    view._live.stop()
    return capture.get()


def test_the_view_tells_truth_from_belief() -> None:
    picture = shown(color_system=None)
    assert "1 of 2 reached, 1 known" in picture
    assert "robot      5.00 s" in picture
    # The newest frame was sampled at 2 s where x was 2 m; at 5 s the robot is at (6.3, 0.4).
    assert "telemetry from 2.00 s " in picture
    assert "3.00 s, error 4.3 m" in picture
    assert "last known position (2.0, 0.0)" in picture
    assert "2.00 s, newest measured" in picture
    assert re.search(r"1 upload_plan near, far +0\.00 s +1\.00 s +failed +failed +2\.00 s", picture)
    assert "failure: timeout: 1 of 2" in picture


def test_before_anything_is_heard_the_operator_knows_nothing() -> None:
    picture = shown(upto=4, color_system=None)
    assert "no telemetry yet" in picture
    assert "under way" not in picture  # it has not arrived
    assert "not yet measured" in picture


def test_no_color_is_respected(monkeypatch: pytest.MonkeyPatch) -> None:
    colored = shown(color_system="standard")
    monkeypatch.setenv("NO_COLOR", "1")
    assert "\x1b[32m" in colored
    assert "\x1b[32m" not in shown(color_system="standard")


def test_the_view_does_not_slow_the_flight_down(monkeypatch: pytest.MonkeyPatch) -> None:
    view = LiveView(Console(file=io.StringIO(), force_terminal=True), "hand", ())
    drawn: list[float] = []
    clock = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    monkeypatch.setattr(view._live, "update", lambda *_, **__: drawn.append(clock[0]))
    message = next(message for message in flight() if isinstance(message, State))
    for _ in range(1000):
        view(message)
        clock[0] += 0.001
    # A second went by in which it drew once at the beginning and then each tenth of it.
    assert len(drawn) == pytest.approx(1.0 / PERIOD_S, abs=1)


def happenings(messages: list[Message]) -> list[str]:
    return [told.line for told in map(happening, messages) if told is not None]


def test_happenings_are_told_on_their_clock() -> None:
    lines = happenings(list(flight()))
    assert "     2.000 s  robot     near reached" in lines
    assert "     2.000 s  operator  ack received: command 1 started, 1.000 s ago" in lines
    assert "     5.000 s  operator  ack received: command 1 failed (timeout), 1.000 s ago" in lines
    assert not any("accepted" in line for line in lines)
    failed = [told for told in map(happening, flight()) if told and "failed (timeout)" in told.text]
    assert [told.severity for told in failed] == [Severity.ERROR]


@pytest.mark.parametrize(
    ("count", "text"), [(0, "0 B"), (999, "999 B"), (1000, "1.0 kB"), (2_345_678, "2.3 MB"), (7 * 10**10, "70.0 GB")]
)
def test_sizes(count: int, text: str) -> None:
    assert size(count) == text


@pytest.mark.parametrize("width", [40, 80, 99, 100, 120])
def test_tables_keep_to_the_width(width: int) -> None:
    summary = summarize(flight(), (replace(NEAR, name="a rather long name of a waypoint" * 2), FAR))
    out = Console(file=io.StringIO(), width=width, markup=False, color_system=None)
    out.print(waypoint_table(summary))
    out.print(command_table(summary))
    text = out.file.getvalue()  # type: ignore[attr-defined]
    assert max(map(len, text.splitlines())) <= width
    left_out = " ".join(text.rpartition("#")[2].split()).partition("left out: ")[2]
    assert ("down" in left_out, "a wider terminal shows them" in left_out) == (width < 80, width < 80)


def test_pace_waits_as_long_as_it_should(monkeypatch: pytest.MonkeyPatch) -> None:
    now = [50.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])

    def idle(duration_s: float) -> None:
        assert 0 < duration_s <= 0.05
        now[0] += duration_s

    pace = Pace(4.0, idle)
    pace.wait_for(8 * NS_PER_S)
    assert now[0] == pytest.approx(52.0)
    pace.change(1.0)
    pace.wait_for(9 * NS_PER_S)
    assert now[0] == pytest.approx(53.0)
    now[0] += 10.0  # the process was stopped; it does not run after what it has missed
    pace.wait_for(10 * NS_PER_S)
    pace.wait_for(11 * NS_PER_S)
    assert now[0] == pytest.approx(64.0)


def test_pace_ends_when_it_is_told_to() -> None:
    asked = iter([False, False, True])
    Pace(0.001, lambda _: None).wait_for(NS_PER_S, lambda: next(asked))
    assert next(asked, None) is None


def test_how_often_a_command_was_sent_has_a_column_where_one_was_sent_again() -> None:
    def table(*more: CommandStage) -> str:
        out = Console(file=io.StringIO(), width=120, markup=False)
        with out.capture() as capture:
            out.print(command_table(summarize([*flight(), *more])))
        return capture.get()

    assert "sent" not in table().splitlines()[0].split()
    again = table(stage(2.0, Stage.LOST, Clock.LINK), stage(3.0, Stage.QUEUED, Clock.OPERATOR, attempt=2))
    assert "2, 1 lost" in again
