"""A link that loses so many heartbeats on end that the robot takes it for lost."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from waypointctl.flight.forecast.chain import Chain
from waypointctl.flight.forecast.duration import Expected
from waypointctl.flight.forecast.finding import Finding
from waypointctl.mission.mission import Mission

_SELDOM: Final = 0.05  # of the flights; what happens more often is warned of
_FOLLOWS: Final = {
    "hold": "it stands until the next one",
    "return_home": "it gives the plan up and walks home",
}


def heartbeat_findings(mission: Mission, own: Expected) -> Iterator[Finding]:
    """Yield that the robot is likely to take the link for lost, where a rule follows from that."""
    rule = mission.onboard.link_loss
    if rule is None or rule.do not in _FOLLOWS:
        return
    chance = taken_for_lost(mission, own)
    if chance > _SELDOM:
        run = _run_of(mission)
        lost = "one heartbeat" if run == 1 else f"{run} heartbeats on end"
        text = (
            f"the link loses {lost} within the {own.time_s:.0f} s expected with a probability of {chance:.0%}; the "
            f"robot takes it for lost after {rule.after_s:g} s: {_FOLLOWS[rule.do]}"
        )
        yield Finding("heartbeat", ("onboard", "link_loss", "after_s"), text)


def taken_for_lost(mission: Mission, own: Expected) -> float:
    """Return the probability that so many heartbeats on end are lost that the link counts as lost, at least once."""
    beat_s, loss = mission.operator.heartbeat_s, mission.link.up.loss
    if beat_s is None or own.time_s is None or not loss or _run_of(mission) < 1:
        return 0.0
    chain = Chain(loss)
    return chain.run_lost(chain.after(1), int(own.time_s / beat_s), _run_of(mission))  # the first command went before


def _run_of(mission: Mission) -> int:
    """Return how many heartbeats have to be lost on end; 0 where the link counts as lost between any two of them."""
    rule, beat_s = mission.onboard.link_loss, mission.operator.heartbeat_s
    return 0 if rule is None or beat_s is None or rule.after_s <= beat_s else int(rule.after_s / beat_s)
