"""Whole flights over links that bring commands in another order than they were issued in."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.flight.flying import STILL, Scripted, flown, mission_of, only
from waypointctl.flight.outcome import FlightResult
from waypointctl.log.messages import (
    Clock,
    Command,
    CommandKind,
    CommandStage,
    Event,
    EventKind,
    Message,
    Mode,
    Stage,
    Telemetry,
)

FAR = {"name": "far", "position_m": [500.0, 0.0], "timeout_s": 60.0}
SEED = 0  # the link up, which loses half, loses the plan the first time
SHUFFLING = 22  # another, which loses the abort and the hold


def steered(seed: int, loss: float) -> tuple[FlightResult, list[Message]]:
    """Fly some seconds of continuous steering over a link that shuffles what it carries, both ways."""
    way = {"delay_s": 1.0, "jitter_s": 1.0, "keep_order": False, "loss": loss, "duplicate": 0.1}
    return flown(
        mission_of(
            FAR,
            autonomy="short_range_goal",
            operator={"steering": "continuous", "update_rate_hz": 5.0},
            link={"up": way, "down": way},
            seed=seed,
            expect={"max_time_s": 8.0},
        ),
        Scripted(STILL),
    )


@given(st.integers(0, 10_000), st.sampled_from([0.0, 0.2]))
@settings(max_examples=6, deadline=None)
def test_no_goal_that_was_issued_earlier_pulls_the_robot_back(seed: int, loss: float) -> None:
    _, messages = steered(seed, loss)
    arrived = [command.id for command in only(Command, messages)]
    assert arrived != sorted(arrived), "the link shuffles"
    stages = only(CommandStage, messages)
    started = [stage.command_id for stage in stages if stage.stage is Stage.STARTED]
    assert started == sorted(set(started))
    skipped = [stage for stage in stages if stage.stage is Stage.SKIPPED]
    assert skipped
    assert all(stage.reason.startswith("overtaken by command ") for stage in skipped)


def test_the_ground_makes_nothing_of_a_goal_that_was_overtaken() -> None:
    _, messages = steered(3, 0.0)
    stages = only(CommandStage, messages)
    overtaken = {stage.command_id for stage in stages if stage.stage is Stage.SKIPPED}
    assert overtaken
    assert not [stage for stage in stages if stage.stage is Stage.UNKNOWN]
    again = [event for event in only(Event, messages) if event.kind is EventKind.COMMAND_SENT and "again" in event.text]
    assert again == []
    assert {stage.attempt for stage in stages if stage.command_id in overtaken} == {1}


@pytest.mark.parametrize(("halt", "mode"), [("abort", Mode.IDLE), ("hold", Mode.PAUSED)])
def test_a_plan_that_was_lost_and_is_sent_again_does_not_undo_what_stopped_it(halt: str, mode: Mode) -> None:
    mission = mission_of(
        FAR,
        link={"up": {"delay_s": 0.5, "loss": 0.5}, "down": {"delay_s": 0.5}},
        schedule=[{"at_s": 1.0, "do": halt}],
        seed=SEED,
        expect={"max_time_s": 9.0},
    )
    _, messages = flown(mission)
    arrived = [(command.kind, command.id) for command in only(Command, messages)]
    assert arrived[0][1] == 2, "the plan, command 1, was lost the first time"
    assert (CommandKind.UPLOAD_PLAN, 1) in arrived
    assert only(Telemetry, messages)[-1].mode is mode


def test_what_was_sent_again_and_comes_late_leaves_alone_what_was_issued_after_it_for_later() -> None:
    mission = mission_of(
        FAR,
        link={"up": {"delay_s": 0.1, "loss": 0.5}, "down": {"delay_s": 0.1}},
        schedule=[
            {"at_s": 1.0, "do": "abort"},
            {"at_s": 1.2, "do": "go_to", "position_m": [500.0, 9.0], "not_before_s": 8.0},
            {"at_s": 1.4, "do": "hold", "not_before_s": 8.0},
            {"at_s": 1.6, "do": "resume", "not_before_s": 8.0},
        ],
        seed=SHUFFLING,
        expect={"max_time_s": 9.0},
    )
    _, messages = flown(mission)
    arrived = list(dict.fromkeys(command.id for command in only(Command, messages)))
    assert arrived == [1, 3, 5, 4, 2], "the link loses the abort and the hold the first time"
    stages = [stage for stage in only(CommandStage, messages) if stage.clock is Clock.ROBOT]
    assert [stage.command_id for stage in stages if stage.stage is Stage.STARTED] == [1, 2, 3, 4, 5]
    assert [(stage.command_id, stage.reason) for stage in stages if stage.reason] == [
        (1, "by command 2"),
        (3, "flight ended"),
    ]
    assert only(Telemetry, messages)[-1].mode is Mode.NAVIGATING
