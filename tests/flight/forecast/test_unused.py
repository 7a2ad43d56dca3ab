from __future__ import annotations

import pytest

from waypointctl.flight.forecast.unused import unused_findings
from waypointctl.mission.files import parse_mission

BASE = "name: n\npolicy: p\nwaypoints: [[8, 6], [8, 16]]\n"
HOME = "onboard: {slip: 1 m, link_loss: {after: 5 s, do: return_home}}\n"
FOR = {
    "mission": "mission",
    "steered": "heading",
    "thinks": "waypoint or heading",
    "board": "mission, waypoint or heading",
}


def found(more: str) -> list[tuple[str, str]]:
    mission = parse_mission((BASE + more).encode(), "m.yaml")
    findings = list(unused_findings(mission))
    assert {each.kind for each in findings} <= {"unused"}
    return [(".".join(map(str, each.path)), each.text) for each in findings]


@pytest.mark.parametrize(
    ("field", "path", "used_under", "said"),
    [
        ("operator: {think: 2 s}", "operator.think_s", ("waypoint", "heading"), "thinks"),
        ("operator: {released: 1}", "operator.released", ("mission",), "mission"),
        ("operator: {lookahead: 2 m}", "operator.lookahead_m", ("heading",), "steered"),
        ("operator: {steering: continuous}", "operator.steering", ("heading",), "steered"),
        ("onboard: {slip: 1 m}", "onboard.slip_m", ("mission", "waypoint", "heading"), "board"),
        ("onboard: {stuck: {for: 3 s}}", "onboard.stuck", ("mission", "waypoint", "heading"), "board"),
        ("on_failure: {retry: 1}", "on_failure.retry", ("mission", "waypoint", "heading"), "board"),
        ("onboard: {on_failure: {retry: 1}}", "onboard.on_failure.retry", ("mission", "waypoint", "heading"), "board"),
    ],
)
@pytest.mark.parametrize("autonomy", ["mission", "waypoint", "heading", "joint"])
def test_what_an_autonomy_does_not_look_at_is_found(
    field: str, path: str, used_under: tuple[str, ...], said: str, autonomy: str
) -> None:
    text = f"does nothing under autonomy {autonomy}; it is for autonomy {FOR[said]}"
    assert found(f"{field}\nautonomy: {autonomy}\n") == ([] if autonomy in used_under else [(path, text)])


@pytest.mark.parametrize(
    ("more", "path", "text"),
    [
        (
            "operator: {update_rate: 3 Hz}\nautonomy: heading\n",
            "operator.update_rate_hz",
            "does nothing while steering is move_and_wait; it is for 'steering: continuous'",
        ),
        (
            "operator: {heartbeat: 3 s}\n",
            "operator.heartbeat_s",
            "does nothing without 'onboard.link_loss', the rule that listens for heartbeats",
        ),
        (
            "commands: {acknowledged: false, retries: 9}\n",
            "commands.retries",
            "does nothing while acknowledged is false: nothing is sent again",
        ),
        (
            "commands: {acknowledged: false, margin: 9 s}\n",
            "commands.margin_s",
            "does nothing while acknowledged is false: nothing is sent again",
        ),
        (
            "on_failure: return_home\nautonomy: joint\n",
            "on_failure.then",
            "does nothing under autonomy joint: when a leg's time is out, the pilot tells the robot to hold",
        ),
    ],
)
def test_what_something_else_leaves_without_effect_is_found(more: str, path: str, text: str) -> None:
    assert found(more) == [(path, text)]


@pytest.mark.parametrize(
    "more",
    [
        "operator: {think: 0 s, released: -1, lookahead: 1 m, steering: move_and_wait, update_rate: 1 Hz}\n",
        "operator: {steering: continuous, update_rate: 3 Hz, lookahead: 3 m, think: 1 s}\nautonomy: heading\n",
        "operator: {heartbeat: 3 s}\nonboard: {link_loss: {after: 9 s}}\n",
        "commands: {acknowledged: false}\n",
        f"{HOME}autonomy: joint\n",  # the way home is walked on board
        "on_failure: skip\nautonomy: joint\n",
        "on_failure: hold\nautonomy: joint\n",
    ],
)
def test_what_has_an_effect_is_not(more: str) -> None:
    assert found(more) == []
