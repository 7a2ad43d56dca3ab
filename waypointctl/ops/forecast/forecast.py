"""A mission's forecast: how long it takes under each autonomy, and what may go wrong."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from waypointctl.mission.mission import Mission
from waypointctl.ops.forecast.budget import Budget
from waypointctl.ops.forecast.delivery import HOPELESS, delivered, delivery_findings
from waypointctl.ops.forecast.duration import AUTONOMIES, Expected, expected
from waypointctl.ops.forecast.effect import Effect, effect_of
from waypointctl.ops.forecast.finding import Finding
from waypointctl.ops.forecast.heartbeats import heartbeat_findings
from waypointctl.ops.forecast.home import home_findings
from waypointctl.ops.forecast.link import link_findings
from waypointctl.ops.forecast.queued import Queued, queued
from waypointctl.ops.forecast.release import release_findings
from waypointctl.ops.forecast.route import route_findings
from waypointctl.ops.forecast.schedule import schedule_findings
from waypointctl.ops.forecast.steering import steering_findings
from waypointctl.ops.forecast.stuck import stuck_findings
from waypointctl.ops.forecast.tolerance import tolerance_findings
from waypointctl.ops.forecast.traffic import Traffic, traffic_of
from waypointctl.ops.forecast.unused import unused_findings


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
        findings: what may go wrong, in no order of weight.
        not_counted: what makes it longer, and is not in the times.
    """

    speed: WalkingSpeed
    expected: tuple[Expected, ...]
    own: Expected
    findings: tuple[Finding, ...]
    not_counted: tuple[str, ...] = ()


def forecast(mission: Mission, speed: WalkingSpeed) -> Forecast:
    """Work out what a mission comes to, without flying it.

    Args:
        mission: with the files that it refers to.
        speed: of the policy.

    Raises:
        MissionError: something is wrong with a file that it refers to.
    """
    traffic, budget = traffic_of(mission), Budget()
    in_turn = sorted(AUTONOMIES, key=lambda each: each != mission.autonomy)  # its own first: it is what is asked
    alone = [expected(mission, speed.mps, traffic, autonomy) for autonomy in in_turn]
    waited = [queued(mission, speed.mps, traffic, each, budget) for each in alone]
    effects = [_got_through(mission, traffic, effect_of(mission, speed.mps, each.expected, budget)) for each in waited]
    times = tuple(sorted((it.expected for it in effects), key=lambda each: AUTONOMIES.index(each.autonomy)))
    effect, queue = effects[0], waited[0]
    own = effect.expected
    findings = [
        *route_findings(mission, speed.mps),
        *release_findings(mission),
        *steering_findings(mission, speed.mps, traffic),
        *stuck_findings(mission, speed.mps),
        *tolerance_findings(mission),
        *home_findings(mission, speed.mps),
        *schedule_findings(mission, traffic, effect),
        *link_findings(mission, traffic, own, queue.follows),
        *delivery_findings(mission, traffic, own),
        *heartbeat_findings(mission, own),
        *unused_findings(mission),
    ]
    limit_s = mission.expect.max_time_s
    if limit_s is not None and own.time_s is not None and own.time_s > limit_s:
        text = f"{limit_s:g} s are allowed, and about {own.time_s:.1f} s are expected"
        findings.append(Finding("max_time", ("expect", "max_time_s"), text))
    return Forecast(speed, times, own, tuple(_once(findings)), tuple(_not_counted(mission, effect, queue)))


def _once(findings: Iterable[Finding]) -> Iterator[Finding]:
    """Yield of what is wrong with a waypoint, each time that it is walked to, the first alone."""
    seen = set()
    for finding in findings:
        key = (finding.kind, finding.path)
        if finding.path[0] != "waypoints" or key not in seen:
            seen.add(key)
            yield finding


def _got_through(mission: Mission, traffic: Traffic, effect: Effect) -> Effect:
    """Return what is expected of a mission over a link that may let nothing of it through."""
    own = effect.expected
    asked = mission.model_copy(update={"autonomy": own.autonomy})
    hopeless = own.time_s is not None and delivered(asked, traffic, own) < HOPELESS
    return replace(effect, expected=replace(own, time_s=None)) if hopeless else effect


def _not_counted(mission: Mission, effect: Effect, queue: Queued) -> Iterator[str]:
    if not queue.counted:
        yield "telemetry in the queue"
    if not effect.counted:
        yield "the schedule"
    if mission.link.up.loss or mission.link.down.loss:
        yield "losses"
    if mission.link.up.jitter_file or mission.link.down.jitter_file:
        yield "jitter"  # as measured: its mean need not be 0
