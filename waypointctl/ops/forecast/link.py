"""What may go wrong on the link: contacts that are too short, telemetry that is too much, a link that seems lost."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, Final

from waypointctl.mission.mission import Mission
from waypointctl.ops.forecast.finding import Finding
from waypointctl.ops.forecast.traffic import (
    ACK_BYTES,
    CONTROL_HZ,
    Traffic,
    action_bytes,
    body_bytes,
    command_bytes,
    frame_bytes,
)
from waypointctl.ops.link.contacts import BITS_PER_BYTE, FOREVER_NS, Contacts, airtime_ns
from waypointctl.ops.link.direction import Direction
from waypointctl.units import seconds

_UP: Final = ("link", "up")
_DOWN: Final = ("link", "down")
_SHORTEST_ROUND_TRIP_S: Final = 0.04  # from here on nobody balances the ant from the ground: docs/delay.md


def link_findings(mission: Mission, traffic: Traffic) -> Iterator[Finding]:
    """Yield what may go wrong between the operator and the robot."""
    yield from _contacts(_UP, traffic.up, "the largest command", command_bytes(mission))
    yield from _contacts(_DOWN, traffic.down, "an acknowledgement", ACK_BYTES)
    yield from _queue(mission, traffic)
    yield from _rates(mission, traffic)
    yield from _link_loss(mission, traffic)
    yield from _joint(mission, traffic)


def _contacts(path: tuple[str, str], way: Direction[Any], what: str, size: int) -> Iterator[Finding]:
    windows = way.contacts.windows
    short = [each for each in windows if airtime_ns(size, each.rate_bps) > each.end_ns - each.begin_ns]
    direction = path[1]
    if way.contacts.place(0, size) is None:
        text = f"{what} ({size} bytes) fits in no contact {direction}: nothing of it will ever arrive"
        yield Finding("contact", (*path, "windows"), text)
    elif short:
        first = short[0]
        text = (
            f"{what} ({size} bytes) takes {seconds(airtime_ns(size, first.rate_bps)):.3g} s, and {len(short)} of "
            f"{len(windows)} contacts {direction} are shorter, the one at {seconds(first.begin_ns):g} s first"
        )
        yield Finding("contact", (*path, "windows"), text)


def _queue(mission: Mission, traffic: Traffic) -> Iterator[Finding]:
    """Yield a queue that has no room for a command that has to wait for the first contact."""
    size, room = command_bytes(mission), traffic.up.queue_bytes
    opens_ns = traffic.up.contacts.next_open_ns(0)
    if size > room and opens_ns:
        text = f"the queue has room for {room} bytes; the first command has {size}, waits for a contact, and is lost"
        yield Finding("queue", (*_UP, "queue_bytes"), text)


def _rates(mission: Mission, traffic: Traffic) -> Iterator[Finding]:
    frame_bps = frame_bytes(mission) * BITS_PER_BYTE * mission.telemetry.rate_hz
    joint = mission.autonomy == "joint"
    needed_down = frame_bps + (body_bytes() * BITS_PER_BYTE * CONTROL_HZ if joint else 0)
    what = "telemetry and the robot's states come" if joint else "telemetry comes"
    yield from _rate(_DOWN, traffic.down.contacts, needed_down, what)
    if joint:
        yield from _rate(_UP, traffic.up.contacts, action_bytes() * BITS_PER_BYTE * CONTROL_HZ, "actions come")


def _rate(path: tuple[str, str], contacts: Contacts, needed_bps: float, what: str) -> Iterator[Finding]:
    has_bps = mean_rate_bps(contacts)
    if has_bps is not None and needed_bps > has_bps:
        text = (
            f"{what} to {needed_bps:.0f} bit/s, and the link {path[1]} carries {has_bps:.0f}: they wait, and are lost"
        )
        yield Finding("rate", (*path, "rate_bps"), text)


def mean_rate_bps(contacts: Contacts) -> float | None:
    """Return what a link can carry in the long run [bit/s], None for any amount.

    Contacts that come again count with their share of the time; of others the fastest counts, while it lasts.
    """
    rates = [window.rate_bps for window in contacts.windows]
    known = [rate for rate in rates if rate is not None]
    if not rates or len(known) < len(rates):
        return None
    if not contacts.period_ns:
        return max(known)
    sent = sum(rate * (window.end_ns - window.begin_ns) for rate, window in zip(known, contacts.windows, strict=True))
    return sent / contacts.period_ns


def _link_loss(mission: Mission, traffic: Traffic) -> Iterator[Finding]:
    """Yield a rule for the loss of the link that would see one where there is none."""
    rule, beat_s = mission.onboard.link_loss, mission.operator.heartbeat_s
    path = ("onboard", "link_loss")
    if rule is None:
        return
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


def _joint(mission: Mission, traffic: Traffic) -> Iterator[Finding]:
    if mission.autonomy != "joint":
        return
    round_trip_s = seconds(traffic.up.delay(0) + traffic.down.delay(0))
    if round_trip_s >= _SHORTEST_ROUND_TRIP_S:
        text = (
            f"autonomy joint over a round trip of {round_trip_s:g} s: actions that old do not keep a robot on its feet"
        )
        yield Finding("delay", ("autonomy",), text)
