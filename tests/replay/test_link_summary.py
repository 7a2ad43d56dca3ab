"""What the link did: counted by hand, and against what arrived in a flight over a bad link."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.replay.hand_made import flight
from tests.replay.rewriting import Flown, fly_once
from waypointctl.log.messages import Ack, CommandStage, DeliveryOutcome, LinkRecord, Stage, Telemetry
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.link_summary import LinkDirectionSummary, LinkSummary
from waypointctl.replay.summary_builder import summarize
from waypointctl.units import seconds

# Acknowledgements are asked for again and again, frames fill the queue.
BAD_LINK = b"""\
name: bad
policy: ./policy
seed: 11
waypoints:
  - {name: here, position: [0.2 m, 0 m], tolerance: 10 m, hold: 4 s}
telemetry: {rate: 20 Hz}
operator: {heartbeat: 1 s}
link:
  up: {delay: 0.1 s, loss: 30 %}
  down: {delay: 0.1 s, loss: 20 %, duplicate: 20 %, rate: 9 kbit/s, queue: 200 B, windows: [{from: 0.5 s, to: 1 h}]}
expect: {max_time: 6 s}
"""


def record(way: str, what: str, fate: DeliveryOutcome, time_ns: int = 0, departs_ns: int = 0) -> LinkRecord:
    return LinkRecord(time_ns, way, what, 1, 10, departs_ns, (), fate)


def test_each_way_is_counted_by_what_became_of_its_messages() -> None:
    records = [
        record("up", "command", DeliveryOutcome.LOST),
        record("up", "heartbeat", DeliveryOutcome.LOST, 5, 9),  # it had waited before
        record("up", "command", DeliveryOutcome.NO_CONTACT, 5, -1),
        record("down", "telemetry", DeliveryOutcome.QUEUE_FULL, 5, -1),
        record("down", "telemetry", DeliveryOutcome.QUEUED, 5, 7),
        record("down", "ack", DeliveryOutcome.DUPLICATED, 5, 5),
        record("down", "ack", DeliveryOutcome.DUPLICATED, 5, 11),
        record("sideways", "ack", DeliveryOutcome.LOST),  # of an altered log
    ]
    lost, queued = DeliveryOutcome.LOST, DeliveryOutcome.QUEUED
    no_contact, queue_full = DeliveryOutcome.NO_CONTACT, DeliveryOutcome.QUEUE_FULL
    up = LinkDirectionSummary({("command", lost): 1, ("heartbeat", lost): 1, ("command", no_contact): 1}, 1, 4)
    twice = ("ack", DeliveryOutcome.DUPLICATED)
    down = LinkDirectionSummary({("telemetry", queue_full): 1, ("telemetry", queued): 1, twice: 2}, 2, 6)
    assert summarize([*flight(), *records]).link == LinkSummary(up, down)
    assert (up.not_arrived, down.not_arrived) == ({"command": 2, "heartbeat": 1}, {"telemetry": 1})
    assert (up.count(lost), up.count(no_contact), down.count(queue_full)) == (2, 1, 1)
    assert up
    assert down


def test_where_nothing_is_lost_doubled_or_late_there_is_nothing_to_tell() -> None:
    link = summarize(flight()).link
    assert link == LinkSummary()
    assert not link.up
    assert not link.down


@pytest.fixture(scope="module")
def bad(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Flown:
    folder: Path = tmp_path_factory.mktemp("bad")
    return fly_once(folder, make_policy(folder / "policy", gain=0.0), BAD_LINK)


def test_the_counts_are_what_is_missing_or_there_twice_in_the_log(bad: Flown) -> None:
    messages = bad.messages
    link = summarize(messages).link
    arrived = [message.frame for message in messages if isinstance(message, Telemetry)]
    missing = set(range(max(arrived) + 1)) - set(arrived)
    after = [m for m in messages if isinstance(m, LinkRecord) and m.message == "telemetry" and m.number > max(arrived)]
    assert link.down.not_arrived["telemetry"] == len(missing) + sum(not m.arrives_ns for m in after)
    stages = [m for m in messages if isinstance(m, CommandStage) and m.stage is Stage.LOST]
    assert link.up.not_arrived.get("command", 0) == len(stages)
    assert link.up.not_arrived["heartbeat"] > 0
    acks = [message for message in messages if isinstance(message, Ack)]
    twice = len(arrived) - len(set(arrived)) + len(acks) - len({(a.stage, a.issued_ns) for a in acks})
    ends_ns = max(message.received_ns for message in messages if isinstance(message, Ack | Telemetry))
    late = [m for m in messages if isinstance(m, LinkRecord) and len(m.arrives_ns) == 2 and m.arrives_ns[1] > ends_ns]
    assert link.down.count(DeliveryOutcome.DUPLICATED) == twice + len(late)
    assert link.down.count(DeliveryOutcome.QUEUE_FULL) > 0
    assert link.down.waited > 0
    emptied_s = 200 * 8 / 9000  # the queue at the link's rate, after half a second without contact
    assert 0.5 <= seconds(link.down.longest_wait_ns) <= 0.5 + emptied_s
