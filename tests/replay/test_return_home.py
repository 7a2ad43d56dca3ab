"""Ways home, told from a flight's messages: why each began, how it ended, and what the operator knew of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from tests.replay.hand_made import event, frame, stage
from waypointctl.flight.command_life import FLIGHT_ENDED
from waypointctl.flight.fly import fly
from waypointctl.log.messages import Ack, Command, CommandKind, EventKind, Message, Mode, Stage
from waypointctl.mission.files import MissionFile, parse_mission
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.flight_log import FlightLog
from waypointctl.replay.legs import ReturnEnding, ReturnHome
from waypointctl.replay.summary_builder import summarize
from waypointctl.units import ns

BY_RULE = event(4, EventKind.RETURN_STARTED, "returning home: timeout", command_id=-1)
BY_COMMAND = event(4, EventKind.RETURN_STARTED, "returning home", command_id=7)
REACHED = event(9, EventKind.HOME_REACHED, "home reached")


def returns(*messages: Message) -> tuple[ReturnHome, ...]:
    return summarize(messages).returns


def command(command_id: int, kind: CommandKind) -> Command:
    return Command(command_id, kind, (), "abort", 0, ns(1.0))


@pytest.mark.parametrize(
    ("then", "ending", "ended_s"),
    [
        ([], ReturnEnding.OPEN, None),
        ([REACHED], ReturnEnding.REACHED, 9),
        ([REACHED, event(12, EventKind.FALL, "")], ReturnEnding.REACHED, 9),
        ([event(6, EventKind.PLAN_FAILED, "plan aborted")], ReturnEnding.FAILED, 6),
        ([event(6, EventKind.FALL, "the robot has fallen")], ReturnEnding.FALLEN, 6),
        ([event(6, EventKind.LEG_STARTED, "driving to near", waypoint=0)], ReturnEnding.CALLED_OFF, 6),
        (
            [
                event(6, EventKind.NAVIGATION_PAUSED, "stopped"),
                event(8, EventKind.NAVIGATION_RESUMED, "navigation resumed"),
            ],
            ReturnEnding.OPEN,
            None,
        ),
        ([command(9, CommandKind.ABORT), stage(6, Stage.COMPLETED, command_id=9)], ReturnEnding.CALLED_OFF, 6),
        ([command(9, CommandKind.HOLD), stage(6, Stage.COMPLETED, command_id=9)], ReturnEnding.OPEN, None),
    ],
)
def test_a_rules_way_home_ends_once(then: list[Message], ending: ReturnEnding, ended_s: float | None) -> None:
    (way,) = returns(BY_RULE, *then)
    assert (way.began_ns, way.cause, way.command_id) == (ns(4.0), "timeout", None)
    assert (way.ending, way.ended_ns) == (ending, None if ended_s is None else ns(ended_s))


@pytest.mark.parametrize(
    ("ended", "reason", "ending"),
    [
        (Stage.CANCELLED, "by command 9", ReturnEnding.CALLED_OFF),
        (Stage.EXPIRED, "not completed in time", ReturnEnding.CALLED_OFF),
        (Stage.CANCELLED, FLIGHT_ENDED, ReturnEnding.OPEN),
    ],
)
def test_a_commanded_way_home_ends_with_its_command(ended: Stage, reason: str, ending: ReturnEnding) -> None:
    (way,) = returns(BY_COMMAND, stage(5, ended, reason=reason, command_id=7))
    assert (way.cause, way.command_id, way.ending) == ("command 7", 7, ending)


def test_another_one_calls_the_first_off() -> None:
    first, second = returns(BY_RULE, replace(BY_COMMAND, time_ns=ns(6.0)), REACHED)
    assert (first.ending, first.ended_ns, second.ending) == (ReturnEnding.CALLED_OFF, ns(6.0), ReturnEnding.REACHED)


def test_the_operator_knows_what_telemetry_has_told() -> None:
    walking = replace(frame(1, 3.9, 2.0, ()), mode=Mode.RETURNING)  # sampled before, of another way home
    returning = replace(frame(2, 4.2, 2.0, ()), mode=Mode.RETURNING)
    standing = replace(frame(3, 9.2, 0.0, ()), mode=Mode.SAFE)
    lost_spans: list[Message] = [BY_RULE, walking]
    begun: list[Message] = [returning, REACHED]
    assert (returns(*lost_spans)[0].began_known_ns, returns(*lost_spans)[0].ended_known_ns) == (None, None)
    (way,) = returns(*lost_spans, *begun)
    assert (way.began_known_ns, way.ended_known_ns) == (ns(5.2), None)
    (way,) = returns(*lost_spans, *begun, standing)
    assert (way.began_known_ns, way.ended_known_ns) == (ns(5.2), ns(10.2))


def test_the_operator_knows_what_the_commands_acknowledgements_have_told() -> None:
    def ack(command_id: int, which: Stage, issued_s: float) -> Ack:
        return Ack(command_id, which, "", ns(issued_s), ns(issued_s + 1))

    others = (BY_COMMAND, ack(3, Stage.FAILED, 4.0), ack(7, Stage.RECEIVED, 4.0))
    assert returns(*others)[0].began_known_ns is None
    (way,) = returns(*others, ack(7, Stage.STARTED, 4.0), REACHED, ack(7, Stage.COMPLETED, 9.0))
    assert (way.began_known_ns, way.ended_known_ns) == (ns(5.0), ns(10.0))


FLIGHT = """\
name: home
policy: ./policy
waypoints: [{name: away, position: [30 m, 0 m], timeout: 1 s}]
link: {delay: 100 ms}
on_failure: return_home
onboard: {home: {position: [0.3 m, 0.2 m], tolerance: TOLERANCE, timeout: 1 s}}
"""


@pytest.mark.parametrize(("tolerance", "ending"), [("5 m", ReturnEnding.REACHED), ("0.1 m", None)])
def test_of_a_flight(
    tmp_path: Path, make_policy: Callable[..., LoadedPolicy], tolerance: str, ending: ReturnEnding | None
) -> None:
    source = FLIGHT.replace("TOLERANCE", tolerance).encode()
    file = MissionFile(parse_mission(source, "m.yaml"), source, tmp_path / "m.yaml")
    path = tmp_path / "f.mcap"
    fly(file, make_policy(tmp_path / "policy", gain=0.0), log=path)
    summary = FlightLog.open(path).summary
    (way,) = summary.returns
    assert (way.cause, way.command_id) == ("timeout", None)
    assert way.began_ns > ns(1.0)
    assert way.ending is not ReturnEnding.REACHED if ending is None else way.ending is ending
    assert summary.home is not None
    assert (summary.home.x_m, summary.home.y_m) == (0.3, 0.2)
    assert summary.home_distance_m == pytest.approx(
        float(((summary.truth.x_m[-1] - 0.3) ** 2 + (summary.truth.y_m[-1] - 0.2) ** 2) ** 0.5)
    )
