"""What may go wrong on the link: contacts that are too short, telemetry that is too much, a link that seems lost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from operator import itemgetter
from typing import Any, Final, TypeAlias

from waypointctl.flight.forecast.duration import Expected
from waypointctl.flight.forecast.finding import Finding
from waypointctl.flight.forecast.joint import control_rates, joint_findings
from waypointctl.flight.forecast.losses import loss_findings
from waypointctl.flight.forecast.traffic import (
    ACK_BYTES,
    Traffic,
    command_bytes,
    frame_bytes,
    mean_rate_bps,
    telemetry_bps,
)
from waypointctl.flight.link.contacts import FOREVER_NS, Contacts, airtime_ns
from waypointctl.flight.link.direction import Direction
from waypointctl.mission.link import Way
from waypointctl.mission.mission import Mission
from waypointctl.units import seconds

_UP: Final = ("link", "up")
_DOWN: Final = ("link", "down")

_LATE: Final = "they wait, and come later and later: the robot falls"
_FOLLOWS: Final = "what is too much waits, and acknowledgements behind it; once the queue is full they are lost"

Path: TypeAlias = tuple[str, str]


def link_findings(mission: Mission, traffic: Traffic, own: Expected, follows: str = "") -> Iterator[Finding]:
    """Yield what may go wrong between the operator and the robot.

    Args:
        mission: that has the link.
        traffic: the link.
        own: what is expected of the mission.
        follows: what follows for it from telemetry that waits, in words; empty where that is not known.
    """
    yield from loss_findings(mission.link)
    largest = command_bytes(mission)
    yield from _contacts(mission, _UP, traffic.up, {"the largest command": largest})
    down = {"an acknowledgement": ACK_BYTES, "a frame of telemetry": frame_bytes(mission)}
    yield from _contacts(mission, _DOWN, traffic.down, down)
    yield from _never(mission, traffic, own)
    yield from _queue_up(traffic.up, largest)
    yield from _queue_down(traffic.down, down)
    yield from _rates(mission, traffic, follows)
    yield from _link_loss(mission, traffic, own)
    yield from joint_findings(mission, traffic)


def _contacts(mission: Mission, path: Path, way: Direction[Any], sizes: Mapping[str, int]) -> Iterator[Finding]:
    """Yield the largest of some messages that is too long for a contact."""
    windows = way.contacts.windows
    what, size = max(sizes.items(), key=itemgetter(1))
    never = [(name, each) for name, each in sizes.items() if way.contacts.place(0, each) is None]
    short = [each for each in windows if airtime_ns(size, each.rate_bps) > each.end_ns - each.begin_ns]
    direction = path[1]
    if never:
        what, size = never[0]
        text = f"{what} ({size} bytes) fits in no contact {direction}: nothing of it will ever arrive"
        yield Finding("contact", _contact_path(mission, path), text)
    elif short:
        first = short[0]
        text = (
            f"{what} ({size} bytes) takes {seconds(airtime_ns(size, first.rate_bps)):.3g} s, and {len(short)} of "
            f"{len(windows)} contacts {direction} are shorter, the one at {seconds(first.begin_ns):g} s first"
        )
        yield Finding("contact", _contact_path(mission, path), text)


def _contact_path(mission: Mission, path: Path) -> tuple[str, ...]:
    """Return where the mission says what contacts there are in a direction."""
    way: Way = getattr(mission.link, path[1])
    return (*path, "windows" if way.contact_plan is None else "contact_plan")


def _never(mission: Mission, traffic: Traffic, own: Expected) -> Iterator[Finding]:
    """Yield why a mission is expected to end never, where nothing else says so."""
    blocked = own.blocked
    if blocked is None:
        return
    path, way, is_dead = (
        (_UP, traffic.up, traffic.up_is_dead) if blocked.way == "up" else (_DOWN, traffic.down, traffic.down_is_dead)
    )
    if is_dead or way.contacts.place(0, blocked.size_bytes) is None:
        return
    what, follows = (
        ("a command", "the mission stops there")
        if blocked.way == "up"
        else ("the robot's answer", "the operator never hears of it")
    )
    text = (
        f"{what} ({blocked.size_bytes} bytes) is ready at {blocked.ready_s:.1f} s and fits in no contact {blocked.way} "
        f"from then on; the last ends at {seconds(way.contacts.windows[-1].end_ns):g} s: {follows}"
    )
    yield Finding("contact", _contact_path(mission, path), text)


def _queue_up(way: Direction[Any], size: int) -> Iterator[Finding]:
    """Yield a queue that has no room for a command that has to wait for a contact."""
    opens_ns = way.contacts.next_open_ns(0)
    if size > way.queue_bytes and (opens_ns or longest_gap_ns(way.contacts)):
        which = "the first command has" if opens_ns else "the largest command has"
        when = "waits for a contact, and is lost" if opens_ns else "is lost where it has to wait for a contact"
        text = f"the queue has room for {way.queue_bytes} bytes; {which} {size}, {when}"
        yield Finding("queue", (*_UP, "queue_bytes"), text)


def _queue_down(way: Direction[Any], sizes: Mapping[str, int]) -> Iterator[Finding]:
    """Yield a queue that has no room for what the robot sends, where it has to wait."""
    waits = any(window.rate_bps is not None for window in way.contacts.windows)
    waits = waits or bool(way.contacts.next_open_ns(0)) or longest_gap_ns(way.contacts) > 0
    too_large = [f"{what} has {size}" for what, size in sizes.items() if size > way.queue_bytes]
    if waits and too_large:
        text = (
            f"the queue has room for {way.queue_bytes} bytes; {', '.join(too_large)}: what has to wait, for a contact "
            "or for what is being sent, is lost"
        )
        yield Finding("queue", (*_DOWN, "queue_bytes"), text)


def _rates(mission: Mission, traffic: Traffic, follows: str) -> Iterator[Finding]:
    if mission.autonomy == "joint":
        rates = control_rates(mission, traffic)
        yield from _rate(_DOWN, *rates["down"], "telemetry and the robot's states come", _LATE)
        yield from _rate(_UP, *rates["up"], "actions come", _LATE)
        return
    has_bps = mean_rate_bps(traffic.down.contacts)
    said = _FOLLOWS + (f"; {follows}" if follows else "")
    yield from _rate(_DOWN, telemetry_bps(mission), has_bps, "telemetry comes", said)


def _rate(
    path: tuple[str, str], needed_bps: float, has_bps: float | None, what: str, follows: str
) -> Iterator[Finding]:
    if has_bps is not None and needed_bps > has_bps:
        text = f"{what} to {needed_bps:.0f} bit/s, and the link {path[1]} carries {has_bps:.0f}: {follows}"
        yield Finding("rate", (*path, "rate_bps"), text)


def _link_loss(mission: Mission, traffic: Traffic, own: Expected) -> Iterator[Finding]:
    """Yield a rule for the loss of the link that would see one where there is none."""
    rule, beat_s = mission.onboard.link_loss, mission.operator.heartbeat_s
    path = ("onboard", "link_loss")
    if rule is None or (beat_s is None and mission.autonomy == "joint"):  # a pilot's actions are heard all the time
        return
    if beat_s is None and own.time_s is not None and own.time_s <= rule.after_s:
        return  # it is over by then
    if beat_s is None:
        text = (
            f"without heartbeats the link counts as lost {rule.after_s:g} s after any command: set operator.heartbeat"
        )
        yield Finding("heartbeat", path, text)
        return
    if rule.after_s <= beat_s:
        text = f"the link counts as lost after {rule.after_s:g} s, and heartbeats are {beat_s:g} s apart"
        yield Finding("heartbeat", path, text)
    gap_s = seconds(longest_gap_ns(traffic.up.contacts))
    if gap_s > rule.after_s:
        text = f"the link counts as lost after {rule.after_s:g} s, and contacts up are up to {gap_s:g} s apart"
        yield Finding("heartbeat", path, text)


def longest_gap_ns(contacts: Contacts) -> int:
    """Return the longest time between two contacts [ns]; what follows the last of them is none."""
    windows = contacts.windows
    gaps = [after.begin_ns - before.end_ns for before, after in pairwise(windows)]
    if windows and contacts.period_ns and windows[-1].end_ns < FOREVER_NS:
        gaps.append(contacts.period_ns - windows[-1].end_ns + windows[0].begin_ns)
    return max(gaps, default=0)
