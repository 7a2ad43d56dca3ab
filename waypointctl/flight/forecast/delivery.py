"""How likely a mission's commands get through a link that loses messages, and are heard of.

A command that has arrived is heard of sooner or later: each frame of telemetry names it. So it counts how often it is
sent until it arrives; the link down matters only where it loses everything for good.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from waypointctl.flight.closing import DEAF_AFTER
from waypointctl.flight.forecast.chain import Chain, FloatArray
from waypointctl.flight.forecast.duration import Expected
from waypointctl.flight.forecast.finding import Finding
from waypointctl.flight.forecast.traffic import Traffic
from waypointctl.mission.mission import Mission
from waypointctl.units import seconds

LIKELY: Final = 0.95  # what gets through less often is warned of
HOPELESS: Final = 1e-9  # what gets through so seldom never does
_ONE_BY_ONE: Final = 50  # commands; those after them fare as the last of them
_MOST_RETRIES: Final = 256  # that are advised


def delivery_findings(mission: Mission, traffic: Traffic, own: Expected) -> Iterator[Finding]:
    """Yield that commands of a mission are likely to be lost as often as they are sent, or never heard of."""
    if own.time_s is None or (chance := delivered(mission, traffic, own)) >= LIKELY:
        return
    count, commands = own.exchanges, mission.commands
    what = (
        "the plan is"
        if mission.autonomy == "mission"
        else f"all {count} commands are"
        if count > 1
        else "the command is"
    )
    said = f"the probability that {what} delivered and acknowledged is {_percent(chance)}"
    if not commands.acknowledged:
        text = f"{said}: nothing is sent again while acknowledged is false"
        yield Finding("loss", ("commands", "acknowledged"), text)
        return
    tries = f"{commands.retries} {'retry' if commands.retries == 1 else 'retries'}"
    follows = "a command that is never acknowledged stays unknown, and the mission fails once nothing more is heard"
    text = f"with {tries}, {said}; {follows}{_advice(mission, traffic, own)}"
    yield Finding("loss", ("commands", "retries"), text)


def delivered(mission: Mission, traffic: Traffic, own: Expected, retries: int | None = None) -> float:
    """Return the probability that all commands of the operator get through, and are heard of.

    Args:
        mission: what it sends, and how hard it tries.
        traffic: its link.
        own: what is expected of it.
        retries: in place of the mission's.
    """
    link = mission.link
    steers = mission.autonomy == "heading" and mission.operator.steering == "continuous"
    if mission.autonomy == "joint" or steers or not (link.up.loss or link.down.loss):
        return 1.0  # what is lost there is followed by the next at once
    exchange = _Exchange(mission, traffic, mission.commands.retries if retries is None else retries)
    frames = mission.telemetry.rate_hz * (own.time_s or 0.0)
    chance, one, state = 1.0, 1.0, exchange.up.after(0)
    counted = min(own.exchanges, _ONE_BY_ONE)
    for place in range(counted):
        over = round(frames * (place + 1) / counted)
        one, state = exchange.succeeds(state, exchange.down.after(over))
        chance *= one
    return chance * float(one ** (own.exchanges - counted))


class _Exchange:
    """One command over both ways of a lossy link."""

    def __init__(self, mission: Mission, traffic: Traffic, retries: int) -> None:
        self.up, self.down = Chain(mission.link.up.loss), Chain(mission.link.down.loss)
        self._tries = retries + 1 if mission.commands.acknowledged else 1
        beat_s = mission.operator.heartbeat_s
        wait_s = seconds(traffic.up.delay(0) + traffic.down.delay(0)) + mission.commands.margin_s
        between = 1 + (int(wait_s / beat_s) if beat_s else 0)  # messages up from one try to the next
        self._step: FloatArray = np.linalg.matrix_power(self.up.step, between)

    def succeeds(self, up: FloatArray, over: FloatArray) -> tuple[float, FloatArray]:
        """Return how likely a command arrives and is heard of, and how the link up is afterwards.

        Args:
            up: (2,) how the link up is before.
            over: (2,) how the link down is when the robot tells the end.
        """
        waiting, after = up, np.zeros(2)
        for _ in range(self._tries):
            after += (waiting * (1 - self.up.lost)) @ self._step
            waiting = (waiting * self.up.lost) @ self._step
        arrives = float(after.sum())
        return arrives * (1 - self.down.all_lost(over, DEAF_AFTER)), after / arrives if arrives else up


def _advice(mission: Mission, traffic: Traffic, own: Expected) -> str:
    """Return how many retries make it likely, where some number does."""
    retries = max(mission.commands.retries, 1)
    while retries <= _MOST_RETRIES:
        retries *= 2
        if (chance := delivered(mission, traffic, own, retries)) >= LIKELY:
            return f"; with {retries} retries the probability is {_percent(chance)}"
    return ""


def _percent(chance: float) -> str:
    return f"{min(chance, 0.999) * 100:.1f} %" if chance >= LIKELY else f"{chance * 100:.0f} %"
