from __future__ import annotations

import pytest

from waypointctl.errors import MissionError
from waypointctl.mission.files import parse_mission
from waypointctl.mission.mission import Mission

BASE = "name: n\npolicy: p\nwaypoints: [[7, 12], [14, 14], [0, 3]]\n"


def parse(more: str) -> Mission:
    return parse_mission((BASE + more).encode(), "m.yaml")


@pytest.mark.parametrize("released", [-1, 0, 3])
def test_as_many_as_there_are_can_be_released(released: int) -> None:
    mission = parse(f"operator: {{released: {released}}}\nschedule: [{{at: 1 s, do: release, released: {released}}}]\n")
    assert mission.operator.released == mission.schedule[0].released == released


def test_rounds_make_the_plan_longer() -> None:
    assert parse("repeat: 2\noperator: {released: 6}\n").num_legs == 6
    with pytest.raises(MissionError, match="6 is more than the 5 waypoints"):
        parse("repeat: 2\nstart_at: WP2\noperator: {released: 6}\n")


def test_each_release_of_more_than_there_is_is_told_with_its_place() -> None:
    text = "operator: {released: 4}\nschedule:\n- {at: 1 s, do: release, released: 2}\n"
    with pytest.raises(MissionError) as caught:
        parse(text + "- {at: 2 s, do: release, released: 5}\n")
    hint = "is more than the 3 waypoints of the plan; write -1 to release them all"
    assert str(caught.value).splitlines()[1:] == [
        f"m.yaml:4:22: operator.released: 4 {hint}",
        f"m.yaml:7:36: schedule[1].released: 5 {hint}",
    ]


@pytest.mark.parametrize(
    ("autonomy", "before", "most"),
    [
        ("mission", "", 1),  # the plan
        ("mission", "{at: 1 s, do: hold}, ", 2),
        ("mission", "{at: 9 s, do: hold}, ", 1),  # sent later
        ("mission", "{at: 5 s, do: hold}, ", 2),  # at the same time, and written before
        ("waypoint", "", 3),  # one a waypoint
        ("waypoint", "{at: 1 s, do: hold}, ", 4),
        ("joint", "", 4),
    ],
)
def test_a_command_that_is_sent_later_cannot_be_cancelled(autonomy: str, before: str, most: int) -> None:
    text = f"autonomy: {autonomy}\nschedule: [{before}{{at: 5 s, do: cancel, command: {{}}}}]\n"
    assert parse(text.replace("{}", f"{most}")).schedule[-1].command == most
    with pytest.raises(MissionError) as caught:
        parse(text.replace("{}", f"{most + 1}"))
    place = len("schedule: [") + len(before) + len("{at: 5 s, do: cancel, command: ") + 1
    entry = 1 if before else 0
    problem = f"no command {most + 1} can have been sent by then: under autonomy {autonomy} at most {most} "
    assert str(caught.value).startswith(f"m.yaml:5:{place}: schedule[{entry}].command: {problem}")


def test_how_many_goals_an_operator_sends_who_steers_nobody_knows() -> None:
    assert (
        parse("autonomy: short_range_goal\nschedule: [{at: 5 s, do: cancel, command: 99}]\n").schedule[0].command == 99
    )
