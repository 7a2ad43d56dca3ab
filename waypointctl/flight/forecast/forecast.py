"""A mission's forecast: how long it takes under each autonomy, and what may go wrong."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final

from waypointctl.flight.forecast.budget import Budget
from waypointctl.flight.forecast.delivery import HOPELESS, delivered, delivery_findings
from waypointctl.flight.forecast.duration import AUTONOMIES, Expected, expected
from waypointctl.flight.forecast.effect import Effect, effect_of, goes_home
from waypointctl.flight.forecast.finding import Finding
from waypointctl.flight.forecast.heartbeats import heartbeat_findings, taken_for_lost
from waypointctl.flight.forecast.home import home_findings
from waypointctl.flight.forecast.link import link_findings
from waypointctl.flight.forecast.queued import Queued, queued
from waypointctl.flight.forecast.release import release_findings
from waypointctl.flight.forecast.route import route_findings
from waypointctl.flight.forecast.schedule import schedule_findings
from waypointctl.flight.forecast.steering import steering_findings
from waypointctl.flight.forecast.stuck import stuck_findings
from waypointctl.flight.forecast.tolerance import tolerance_findings
from waypointctl.flight.forecast.traffic import Traffic, traffic_of
from waypointctl.flight.forecast.unused import unused_findings
from waypointctl.mission.mission import Mission

_SCHEDULE: Final = "the schedule"
_JITTER: Final = "jitter"  # as measured: its mean need not be 0
_EITHER_WAY: Final = {_SCHEDULE, _JITTER}  # what may make a mission shorter, too
_HARMLESS: Final = ("near", "unused")  # kinds of findings by which no mission fails


@dataclass(frozen=True, slots=True)
class WalkingSpeed:
    """How fast a policy walks, and who says so."""

    mps: float
    source: str


@dataclass(frozen=True, slots=True)
class Forecast:
    """What a mission comes to.

    Attributes:
        speed: that it was worked out with.
        expected: for each autonomy.
        own: of them, the mission's.
        chance: the probability that losses of the link let the mission come to its end; 1 where nothing is lost.
        findings: what may go wrong, in no order of weight.
        not_counted: what changes the times, and is not in them.
    """

    speed: WalkingSpeed
    expected: tuple[Expected, ...]
    own: Expected
    chance: float
    findings: tuple[Finding, ...]
    not_counted: tuple[str, ...] = ()

    @property
    def is_lower_bound(self) -> bool:
        """Whether all that is not counted can only make the mission longer."""
        return bool(self.not_counted) and not set(self.not_counted) & _EITHER_WAY


def forecast(mission: Mission, speed: WalkingSpeed) -> Forecast:
    """Work out what a mission comes to, without flying it.

    Args:
        mission: with the files that it refers to.
        speed: of the policy.

    Raises:
        MissionError: something is wrong with a file that it refers to.
    """
    traffic, budget = traffic_of(mission), Budget()
    on_the_way = [
        *route_findings(mission, speed.mps),
        *release_findings(mission),
        *steering_findings(mission, speed.mps, traffic),
        *stuck_findings(mission, speed.mps),
        *tolerance_findings(mission),
        *home_findings(mission, speed.mps),
    ]
    doubt = next((finding.text for finding in on_the_way if finding.consequence is not None), "")
    in_turn = sorted(AUTONOMIES, key=lambda each: each != mission.autonomy)  # its own first: it is what is asked
    alone = [expected(mission, speed.mps, traffic, autonomy) for autonomy in in_turn]
    waited = [queued(mission, speed.mps, traffic, each, budget) for each in alone]
    effects = [_followed(mission, speed.mps, traffic, each.expected, budget, doubt) for each in waited]
    times = tuple(sorted((it.expected for it in effects), key=lambda each: AUTONOMIES.index(each.autonomy)))
    effect, queue = effects[0], waited[0]
    own = effect.expected
    # What else may go wrong is told too where it is expected to fail: of the time that it takes if it does not.
    timed = own if own.time_s is not None else replace(own, time_s=queue.expected.time_s)
    findings = [
        *on_the_way,
        *schedule_findings(mission, traffic, effect),
        *link_findings(mission, traffic, timed, queue.follows),
        *delivery_findings(mission, traffic, timed),
        *heartbeat_findings(mission, timed),
        *unused_findings(mission),
    ]
    limit_s = mission.expect.max_time_s
    if limit_s is not None and timed.time_s is not None and timed.time_s > limit_s:
        text = f"{limit_s:g} s is shorter than the expected duration, about {timed.time_s:.1f} s"
        findings.append(Finding("max_time", ("expect", "max_time_s"), text))
    if own.fails and not any(finding.kind not in _HARMLESS for finding in findings):
        findings.append(Finding("outcome", ("waypoints",), f"the mission is expected to fail: {own.fails}"))
    said = (_concluded(finding, own) for finding in _once(findings))
    chance = _chance(mission, traffic, own)
    return Forecast(speed, times, own, chance, tuple(said), tuple(_not_counted(mission, effect, queue)))


def _concluded(finding: Finding, own: Expected) -> Finding:
    """Return a finding with what follows from it, where the mission is expected to fail."""
    return (
        replace(finding, text=f"{finding.text}: {finding.consequence}")
        if own.fails and finding.consequence
        else finding
    )


def _chance(mission: Mission, traffic: Traffic, own: Expected) -> float:
    """Return how likely it is that nothing which matters is lost."""
    if own.time_s is None:
        return 0.0
    rule = mission.onboard.link_loss
    gives_up = rule is not None and rule.do == "return_home"
    return delivered(mission, traffic, own) * (1 - taken_for_lost(mission, own) if gives_up else 1.0)


def _once(findings: Iterable[Finding]) -> Iterator[Finding]:
    """Yield of what is wrong with a waypoint, each time that it is walked to, the first alone."""
    seen = set()
    for finding in findings:
        key = (finding.kind, finding.path)
        if finding.path[:1] != ("waypoints",) or key not in seen:
            seen.add(key)
            yield finding


def _followed(
    mission: Mission, speed_mps: float, traffic: Traffic, without: Expected, budget: Budget, doubt: str
) -> Effect:
    """Return what is expected of a mission with its schedule and rules, its link's losses and its time limit."""
    effect = effect_of(mission, speed_mps, without, budget, doubt)
    own, limit_s = effect.expected, mission.expect.max_time_s
    if own.time_s is None:
        return effect
    asked = mission.model_copy(update={"autonomy": own.autonomy})
    if delivered(asked, traffic, own) < HOPELESS:
        return replace(effect, expected=replace(own, time_s=None, fails="the link loses what it needs"))
    if limit_s is not None and own.time_s > limit_s:
        why = f"the mission takes {own.time_s:.1f} s, expect.max_time is {limit_s:g} s"
        return replace(effect, expected=replace(own, fails=why))
    return effect


def _not_counted(mission: Mission, effect: Effect, queue: Queued) -> Iterator[str]:
    own = effect.expected
    if not queue.counted:
        yield "telemetry in the queue"
    if not effect.counted:
        yield _SCHEDULE
    elif own.time_s is not None and effect.rehearsed is None and goes_home(mission):
        yield "the way home"
    if mission.link.up.loss or mission.link.down.loss:
        yield "losses"
    if next(tolerance_findings(mission), None) is not None:
        yield "the smallest tolerances"
    rule = mission.onboard.link_loss
    if rule is not None and rule.do == "hold" and next(heartbeat_findings(mission, own), None) is not None:
        yield "holds while heartbeats are lost"
    if mission.link.up.jitter_file or mission.link.down.jitter_file:
        yield _JITTER
