from __future__ import annotations

import numpy as np
import pytest

from waypointctl.flight.forecast.losses import loses_all, loss_findings
from waypointctl.flight.link.loss import GilbertElliott, RandomLoss
from waypointctl.mission.files import parse_mission
from waypointctl.mission.link import Bursts, Loss

BASE = "name: n\npolicy: p\nwaypoints: [[8, 6]]\n"
NEVER_RECOVERS = "never recovers (r is 0): after some 50 messages, on average, every one is lost"


def found(link: str) -> list[tuple[tuple[str | int, ...], str]]:
    mission = parse_mission(f"{BASE}link: {link}\n".encode(), "m.yaml")
    findings = list(loss_findings(mission.link))
    assert {each.kind for each in findings} <= {"loss"}
    return [(each.path, each.text) for each in findings]


@pytest.mark.parametrize(
    ("link", "path", "text"),
    [
        ("{up: {loss: 1}}", ("link", "up", "loss"), "every message up is lost: no command ever arrives"),
        (
            "{down: {loss: 100 %}}",
            ("link", "down", "loss"),
            "every message down is lost: nothing is ever heard of the robot",
        ),
        (
            "{loss: {p: 1, r: 1, one_minus_h: 1, one_minus_k: 1}}",
            ("link", "up", "loss"),
            "every message is lost, both ways: no command ever arrives, and nothing is ever heard of the robot",
        ),
        ("{down: {loss: {p: 2 %, r: 0}}}", ("link", "down", "loss"), f"the link down {NEVER_RECOVERS}"),
        ("{loss: {p: 2 %, r: 0}}", ("link", "up", "loss"), f"the link up and down {NEVER_RECOVERS}"),
    ],
)
def test_a_link_that_loses_everything_is_found(link: str, path: tuple[str, ...], text: str) -> None:
    assert found(link) == [(path, text)]


@pytest.mark.parametrize(
    "link",
    ["{loss: 0.99}", "{loss: {p: 1, r: 0.01}}", "{loss: {p: 0.5, r: 0, one_minus_h: 0.9}}", "{loss: {p: 0, r: 0}}"],
)
def test_a_link_that_lets_something_through_is_not(link: str) -> None:
    assert found(link) == []


@pytest.mark.parametrize(
    "loss",
    [
        1.0,
        0.9,
        *(
            Bursts(p=p, r=r, one_minus_h=h, one_minus_k=k)
            for p in (0.0, 0.3, 1.0)
            for r in (0.0, 0.3, 1.0)
            for h in (0.5, 1.0)
            for k in (0.0, 0.5, 1.0)
        ),
    ],
)
def test_what_is_said_to_lose_all_is_what_loses_all(loss: Loss) -> None:
    # Of what does not lose all, each lets a message of the first 20 through in at least one of a hundred flights.
    lost = [each() for each in (_model(loss, seed) for seed in range(100)) for _ in range(20)]
    assert all(lost) == loses_all(loss)


def _model(loss: Loss, seed: int) -> GilbertElliott | RandomLoss:
    rng = np.random.default_rng(seed)
    if isinstance(loss, Bursts):
        return GilbertElliott(loss.p, loss.r, loss.one_minus_h, loss.one_minus_k, rng)
    return RandomLoss(loss, rng)
