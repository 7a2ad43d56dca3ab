"""Findings on the link: contacts, queues and rates that are too small for the traffic, and a link that is dead."""

from __future__ import annotations

from collections.abc import Iterator
from operator import itemgetter
from typing import Final

from waypointctl.flight.checks import Finding
from waypointctl.flight.checks.traffic import Traffic
from waypointctl.flight.link.contacts import Contacts, airtime_ns
from waypointctl.mission.link import Bursts, Link, Loss
from waypointctl.mission.mission import Mission
from waypointctl.units import seconds

# From this round trip on the ant cannot be balanced remotely: 0 of 20 flights of each route, against 19 and 13 of
# 20 at 0.02 s (docs/delay.md, "joint, by round trip").
JOINT_FALLS_FROM_S: Final = 0.04

_WAYS: Final = ("up", "down")
_ALL_LOST: Final = {
    ("up",): "every message up is lost: no command ever arrives",
    ("down",): "every message down is lost: no telemetry ever arrives",
    _WAYS: "every message is lost, both ways: no command and no telemetry ever arrives",
}


def link_findings(mission: Mission, traffic: Traffic, least_s: float) -> Iterator[Finding]:
    """Yield what may go wrong between the operator and the robot.

    Args:
        mission: that has the link.
        traffic: on it.
        least_s: how long the mission takes at least.
    """
    yield from _losses(mission.link)
    yield from _contacts(mission, "up", traffic)
    yield from _contacts(mission, "down", traffic)
    up, down = traffic.up.contacts, traffic.down.contacts
    if _has_gaps(up):
        yield from _queue("up", traffic)
    if down.has_rates or _has_gaps(down):
        yield from _queue("down", traffic)
    yield from _telemetry_rate(traffic)
    yield from _link_loss(mission, traffic, least_s)
    trip_ns = traffic.round_trip_ns if (mission.autonomy, mission.robot) == ("joint", "ant") else None
    if trip_ns and seconds(trip_ns) >= JOINT_FALLS_FROM_S:
        text = (
            f"autonomy joint over a round trip of {seconds(trip_ns):.3g} s: the ant fell on every flight of the delay "
            f"study from {JOINT_FALLS_FROM_S:g} s on (docs/delay.md); choose autonomy mission, waypoint "
            f"or short_range_goal"
        )
        yield Finding("delay", ("autonomy",), text)


def loses_all(loss: Loss) -> bool:
    """Tell whether every message is lost, from the first on."""
    if isinstance(loss, Bursts):  # the link begins good
        return loss.one_minus_k == 1 and (loss.p == 0 or loss.one_minus_h == 1)
    return loss == 1


def _losses(link: Link) -> Iterator[Finding]:
    losses: dict[str, Loss] = {way: getattr(link, way).loss for way in _WAYS}
    if dead := tuple(way for way in _WAYS if loses_all(losses[way])):
        yield Finding("loss", ("link", dead[0], "loss"), _ALL_LOST[dead], prevents=True)
    bursts = {way: loss for way, loss in losses.items() if isinstance(loss, Bursts) and not loses_all(loss)}
    fading = [way for way, loss in bursts.items() if loss.p > 0 and loss.r == 0 and loss.one_minus_h == 1]
    if fading:
        after = 1 / bursts[fading[0]].p
        when = "after the first message" if after == 1 else f"after some {after:.3g} messages, on average,"
        text = f"the link {' and '.join(fading)} never recovers (r is 0): {when} every one is lost"
        yield Finding("loss", ("link", fading[0], "loss"), text)


def _contacts(mission: Mission, way: str, traffic: Traffic) -> Iterator[Finding]:
    """Yield messages that fit in no contact; else the largest one, where some contacts are too short for it."""
    contacts: Contacts = getattr(traffic, way).contacts
    if not contacts.has_rates:
        return
    sizes = traffic.sizes(way)
    path = ("link", way, "windows" if getattr(mission.link, way).contact_plan is None else "contact_plan")
    if never := [(name, size) for name, size in sizes.items() if contacts.place(0, size) is None]:
        what, size = never[0]
        text = f"{what} ({size} bytes) is larger than any contact {way} can carry: it never arrives"
        yield Finding("contact", path, text, prevents=len(never) == len(sizes))
        return
    what, size = max(sizes.items(), key=itemgetter(1))
    windows = contacts.windows
    if short := [each for each in windows if airtime_ns(size, each.rate_bps) > each.end_ns - each.begin_ns]:
        first = short[0]
        text = (
            f"{what} ({size} bytes) takes {seconds(airtime_ns(size, first.rate_bps)):.3g} s to send; {len(short)} of "
            f"{len(windows)} contacts {way} are shorter, first the one at {seconds(first.begin_ns):g} s"
        )
        yield Finding("contact", path, text)


def _has_gaps(contacts: Contacts) -> bool:
    return bool(contacts.next_open_ns(0)) or contacts.longest_gap_ns > 0


def _queue(way: str, traffic: Traffic) -> Iterator[Finding]:
    """Yield a queue that has no room for a message that may have to wait."""
    room: int = getattr(traffic, way).queue_bytes
    if too_large := [f"{what} has {size}" for what, size in traffic.sizes(way).items() if size > room]:
        text = (
            f"the queue has room for {room} bytes; {', '.join(too_large)}: a message that has to wait, for a contact "
            "or for another message, is lost"
        )
        yield Finding("queue", ("link", way, "queue_bytes"), text)


def _telemetry_rate(traffic: Traffic) -> Iterator[Finding]:
    has_bps = traffic.down.contacts.mean_rate_bps
    if has_bps is not None and (needed_bps := traffic.telemetry_bps) > has_bps:
        text = (
            f"telemetry needs {needed_bps:.0f} bit/s, and the link down carries {has_bps:.0f}: telemetry waits, and "
            "acknowledgements behind it; once the queue is full they are lost"
        )
        yield Finding("rate", ("link", "down", "rate_bps"), text)


def _link_loss(mission: Mission, traffic: Traffic, least_s: float) -> Iterator[Finding]:
    """Yield a rule for the loss of the link that would see one where there is none."""
    rule, beat_s = mission.onboard.link_loss, mission.operator.heartbeat_s
    path = ("onboard", "link_loss")
    if rule is None:
        return
    if beat_s is None:
        # The actions of autonomy joint count as heartbeats; and a mission that is over by then needs none.
        if mission.autonomy != "joint" and least_s > rule.after_s:
            text = f"without operator.heartbeat the link counts as lost {rule.after_s:g} s after any command"
            yield Finding("heartbeat", path, text)
        return
    if rule.after_s <= beat_s:
        text = f"the link counts as lost after {rule.after_s:g} s, and heartbeats are {beat_s:g} s apart"
        yield Finding("heartbeat", path, text)
    gap_s = seconds(traffic.up.contacts.longest_gap_ns)
    if gap_s > rule.after_s:
        text = f"the link counts as lost after {rule.after_s:g} s, and contacts up are up to {gap_s:g} s apart"
        yield Finding("heartbeat", path, text)
