"""How likely a mission's commands, and the answers that are waited for, get through a link that loses messages."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from waypointctl.mission.mission import Mission
from waypointctl.ops.forecast.chain import Chain, FloatArray
from waypointctl.ops.forecast.duration import Expected
from waypointctl.ops.forecast.finding import Finding
from waypointctl.ops.forecast.traffic import Traffic
from waypointctl.units import seconds

LIKELY: Final = 0.95  # what gets through less often is warned of
HOPELESS: Final = 1e-9  # what gets through so seldom never does
_FIRST_ANSWERS: Final = 3  # received, accepted, started: a command that arrives is answered so often at once
_ONE_BY_ONE: Final = 50  # commands; those after them fare as the last of them
_MOST_RETRIES: Final = 256  # that are advised


def delivery_findings(mission: Mission, traffic: Traffic, own: Expected) -> Iterator[Finding]:
    """Yield that the commands of a mission, or their answers, are likely to be lost as often as they are sent."""
    if own.time_s is None or (chance := delivered(mission, traffic, own)) >= LIKELY:
        return
    count, commands = own.exchanges, mission.commands
    what = "the plan and its answers get" if mission.autonomy == "mission" else f"{count} commands and answers get"
    said = f"{what} through with a probability of {_percent(chance)}"
    if not commands.acknowledged:
        text = f"{said}: nothing is sent again while acknowledged is false"
        yield Finding("loss", ("commands", "acknowledged"), text)
        return
    tries = f"{commands.retries} {'retry' if commands.retries == 1 else 'retries'}"
    advice = _advice(mission, traffic, own)
    yield Finding("loss", ("commands", "retries"), f"{said} at {tries}, else the operator gives the mission up{advice}")


def delivered(mission: Mission, traffic: Traffic, own: Expected, retries: int | None = None) -> float:
    """Return the probability that all commands of the operator, and the answers that it waits for, get through.

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
        begun, over = (round(frames * (place + part) / counted) for part in (0, 1))
        one, state = exchange.succeeds(state, exchange.down.after(begun), exchange.down.after(over))
        chance *= one
    return chance * float(one ** (own.exchanges - counted))


class _Exchange:
    """One command and its answers, over both ways of a lossy link."""

    def __init__(self, mission: Mission, traffic: Traffic, retries: int) -> None:
        self.up, self.down = Chain(mission.link.up.loss), Chain(mission.link.down.loss)
        self._acknowledged, self._tries = mission.commands.acknowledged, retries + 1
        beat_s = mission.operator.heartbeat_s
        wait_s = seconds(traffic.up.delay(0) + traffic.down.delay(0)) + mission.commands.margin_s
        between = 1 + (int(wait_s / beat_s) if beat_s else 0)  # messages up from one try to the next
        self._step: FloatArray = np.linalg.matrix_power(self.up.step, between)

    def succeeds(self, up: FloatArray, begun: FloatArray, over: FloatArray) -> tuple[float, FloatArray]:
        """Return how likely an exchange succeeds, and how the link up is afterwards.

        Args:
            up: (2,) how the link up is before.
            begun: (2,) how the link down is when the command arrives.
            over: (2,) how it is when the robot tells the end.
        """
        once = 1 - self.down.all_lost(over, 1)
        if not self._acknowledged:
            return float((up * (1 - self.up.lost)).sum()) * once, up @ self._step
        first, state = self._heard(up, 1 - self.down.all_lost(begun, _FIRST_ANSWERS), 1 - self.down.all_lost(begun, 1))
        again, later = self._heard(state, once, once)
        return first * (once + (1 - once) * again), state * once + later * (1 - once)

    def _heard(self, state: FloatArray, first: float, again: float) -> tuple[float, FloatArray]:
        """Return how likely one of the tries is answered, and how the link up is then; 1 of all where none is."""
        new, known = state, np.zeros(2)  # not arrived yet; arrived, and not answered
        after = np.zeros(2)
        for _ in range(self._tries):
            arrives_new, arrives_known = new * (1 - self.up.lost), known * (1 - self.up.lost)
            after += (arrives_new * first + arrives_known * again) @ self._step
            known = (arrives_new * (1 - first) + known * self.up.lost + arrives_known * (1 - again)) @ self._step
            new = (new * self.up.lost) @ self._step
        chance = float(after.sum())
        return chance, after / chance if chance else state


def _advice(mission: Mission, traffic: Traffic, own: Expected) -> str:
    """Return how many retries make it likely, where some number does."""
    retries = max(mission.commands.retries, 1)
    while retries <= _MOST_RETRIES:
        retries *= 2
        if (chance := delivered(mission, traffic, own, retries)) >= LIKELY:
            return f"; with {retries} it is {_percent(chance)}"
    return ""


def _percent(chance: float) -> str:
    return f"{min(chance, 0.999):.1%}" if chance >= LIKELY else f"{chance:.0%}"
