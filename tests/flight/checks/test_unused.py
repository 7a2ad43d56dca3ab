from __future__ import annotations

import pytest

from waypointctl.flight.checks.schedule import unused_findings
from waypointctl.mission.files import parse_mission

BASE = "name: n\npolicy: p\nwaypoints: [[8, 6], [8, 16]]\n"
HOME = "onboard: {stopped_tolerance: 1 m, link_loss: {after: 5 s, do: return_home}}\n"
ON_BOARD = ("mission", "waypoint", "short_range_goal")


def found(more: str) -> list[str]:
    mission = parse_mission((BASE + more).encode(), "m.yaml")
    findings = list(unused_findings(mission))
    assert {each.kind for each in findings} <= {"unused"}
    return [".".join(map(str, each.path)) for each in findings]


@pytest.mark.parametrize(
    ("field", "path", "used_under"),
    [
        ("operator: {think: 2 s}", "operator.think_s", ("waypoint", "short_range_goal")),
        ("operator: {released: 1}", "operator.released", ("mission",)),
        ("operator: {lookahead: 2 m}", "operator.lookahead_m", ("short_range_goal",)),
        ("operator: {steering: continuous}", "operator.steering", ("short_range_goal",)),
        ("onboard: {stopped_tolerance: 1 m}", "onboard.stopped_tolerance_m", ON_BOARD),
        ("onboard: {stuck: {for: 3 s}}", "onboard.stuck", ON_BOARD),
        ("on_failure: {retry: 1}", "on_failure.retry", ON_BOARD),
        ("onboard: {on_failure: {retry: 1}}", "onboard.on_failure.retry", ON_BOARD),
    ],
)
@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "short_range_goal", "joint"])
def test_a_key_that_an_autonomy_does_not_use_is_found(
    field: str, path: str, used_under: tuple[str, ...], autonomy: str
) -> None:
    assert found(f"{field}\nautonomy: {autonomy}\n") == ([] if autonomy in used_under else [path])


@pytest.mark.parametrize(
    ("more", "path"),
    [
        ("operator: {update_rate: 3 Hz}\nautonomy: short_range_goal\n", "operator.update_rate_hz"),
        ("operator: {heartbeat: 3 s}\n", "operator.heartbeat_s"),
        ("commands: {acknowledged: false, retries: 9}\n", "commands.retries"),
        ("commands: {acknowledged: false, margin: 9 s}\n", "commands.margin_s"),
        ("on_failure: return_home\nautonomy: joint\n", "on_failure.then"),
    ],
)
def test_a_key_that_another_key_leaves_without_effect_is_found(more: str, path: str) -> None:
    assert found(more) == [path]


@pytest.mark.parametrize(
    "more",
    [
        "operator: {think: 0 s, released: -1, lookahead: 1 m, steering: move_and_wait, update_rate: 1 Hz}\n",
        "operator: {steering: continuous, update_rate: 3 Hz, lookahead: 3 m, think: 1 s}\nautonomy: short_range_goal\n",
        "operator: {heartbeat: 3 s}\nonboard: {link_loss: {after: 9 s}}\n",
        "commands: {acknowledged: false}\n",
        f"{HOME}autonomy: joint\n",  # the way home is walked on board
        "on_failure: skip\nautonomy: joint\n",
        "on_failure: hold\nautonomy: joint\n",
    ],
)
def test_a_key_that_has_an_effect_is_not_found(more: str) -> None:
    assert found(more) == []
