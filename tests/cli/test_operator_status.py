from __future__ import annotations

from dataclasses import replace

from waypointctl.cli.tui.formatting import status_lines
from waypointctl.log.messages import Ack, Clock, CommandStage, Event, EventKind, Mode, Severity, Stage, Telemetry
from waypointctl.replay.summary_builder import OperatorView
from waypointctl.units import NS_PER_S


def sent(command_id: int, at_s: int) -> Event:
    text = f"command {command_id} sent: go_to \x1b[2J"
    kind = EventKind.COMMAND_SENT
    return Event(at_s * NS_PER_S, kind, Clock.OPERATOR, Severity.INFO, text, command_id=command_id)


def stage(command_id: int, it: Stage, clock: Clock, at_s: int, reason: str = "") -> CommandStage:
    return CommandStage(at_s * NS_PER_S, command_id, it, reason, clock, 1)


def frame(number: int, issued_s: int, received_s: int, *reached: int) -> Telemetry:
    times = issued_s * NS_PER_S, received_s * NS_PER_S
    return Telemetry(number, Mode.NAVIGATING, 1.0 + number, -2.0, 0.5, 1.5707963, 0.25, 3, reached, *times)


def status(*messages: Event | CommandStage | Ack | Telemetry) -> list[str]:
    view = OperatorView()
    for message in messages:
        view(message)
    return status_lines(view, 20 * NS_PER_S)


def test_before_the_first_frame_nothing_is_known_of_the_robot() -> None:
    assert status() == ["robot: no telemetry received yet"]


def test_the_newest_frame_counts_also_if_an_older_one_arrives_later() -> None:
    assert status(frame(1, 12, 14, 0), frame(0, 10, 15)) == [
        "robot, 8.00 s ago: at (2.00, -2.00) m, heading 90 deg, 0.25 m/s, navigating (waypoint 4); waypoints reached: 1"
    ]


def test_a_loss_is_not_heard_of_and_neither_is_what_happens_on_board() -> None:
    log: list[Event | CommandStage | Ack | Telemetry] = [
        sent(1, 2),
        stage(1, Stage.QUEUED, Clock.OPERATOR, 2),
        stage(1, Stage.SENT, Clock.OPERATOR, 3),
        stage(1, Stage.LOST, Clock.LINK, 4),
        stage(1, Stage.RECEIVED, Clock.ROBOT, 5),
    ]
    assert status(*log)[1] == r"command 1 go_to \u001b[2J: sent 17.00 s ago"


def test_what_is_not_known_is_said_and_what_is_heard_later_takes_its_place() -> None:
    late = stage(1, Stage.UNKNOWN, Clock.OPERATOR, 8, "no acknowledgement")
    assert status(sent(1, 2), late)[1].endswith("unknown (no acknowledgement) 12.00 s ago")
    ack = Ack(1, Stage.REJECTED, "geofence", 9 * NS_PER_S, 11 * NS_PER_S)
    assert status(sent(1, 2), late, ack)[1].endswith("rejected (geofence) 11.00 s ago")


def test_a_heading_of_a_little_less_than_zero_is_zero() -> None:
    ahead = replace(frame(0, 10, 15), heading_rad=-0.001)
    assert ", heading 0 deg, " in status(ahead)[0]
