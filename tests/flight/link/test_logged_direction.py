from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pytest
from numpy.typing import NDArray

from waypointctl.flight.link.build import direction
from waypointctl.flight.link.frames import UP, LoggedDirection, named, packets_bytes, size_bytes
from waypointctl.log.messages import Ack, Command, CommandKind, DeliveryOutcome, LinkRecord, Mode, Stage, Telemetry
from waypointctl.log.proto import messages_pb2 as pb
from waypointctl.mission.link import Link

S = 10**9
ACK = Ack(3, Stage.ACCEPTED, "", 7 * S, 8 * S)


@dataclass(frozen=True)
class Snapshot:
    """A frame that the log does not keep as such."""

    step: int
    values: NDArray[np.float64]
    issued_ns: int
    received_ns: int


def logged(records: list[LinkRecord], **way: object) -> LoggedDirection[Ack]:
    return LoggedDirection(direction(Link.model_validate({"up": way}).up, {}, 0, "link.up"), UP, records.append)


def ack_of(number: int, issued_ns: int, received_ns: int) -> Ack:
    return Ack(number, Stage.ACCEPTED, "", issued_ns, received_ns)


def acks(link: LoggedDirection[Ack], *times_s: int) -> None:
    for number, at_s in enumerate(times_s):
        link.send(at_s * S, partial(ack_of, number, at_s * S))


def test_what_is_only_delayed_leaves_no_record() -> None:
    records: list[LinkRecord] = []
    link = logged(records, delay="1 s", jitter="1 s")
    acks(link, 0, 1, 2)
    assert records == []
    assert [ack.command_id for ack in link.direction.due(5 * S)] == [0, 1, 2]


def test_what_waits_is_doubled_or_gets_lost_does() -> None:
    size = size_bytes(ACK)
    waited: list[LinkRecord] = []
    first, second = (size_bytes(ack_of(number, 0, 0)) for number in (0, 1))
    acks(logged(waited, delay="1 s", rate_bps=8 * first), 0, 0)  # the first one takes a second
    arrives_ns = 2 * S + -(-second * S // first)
    assert waited == [LinkRecord(0, UP, "ack", 1, second, S, (arrives_ns,), DeliveryOutcome.QUEUED)]
    doubled: list[LinkRecord] = []
    acks(logged(doubled, delay="1 s", duplicate=1), 7)
    assert doubled == [
        LinkRecord(7 * S, UP, "ack", 0, doubled[0].size_bytes, 7 * S, (8 * S, 8 * S), DeliveryOutcome.DUPLICATED)
    ]
    assert size - 2 <= doubled[0].size_bytes <= size
    lost: list[LinkRecord] = []
    acks(logged(lost, loss=1), 7)
    assert [(each.departs_ns, each.arrives_ns, each.outcome) for each in lost] == [(7 * S, (), DeliveryOutcome.LOST)]
    window = {"windows": [{"from": "10 s", "to": "20 s"}], "queue_bytes": 1.5 * size}
    shut: list[LinkRecord] = []
    acks(logged(shut, **window), 7, 8, 20)
    assert [(each.departs_ns, each.outcome) for each in shut] == [
        (10 * S, DeliveryOutcome.QUEUED),
        (-1, DeliveryOutcome.QUEUE_FULL),
        (-1, DeliveryOutcome.NO_CONTACT),
    ]


def test_a_size_is_what_the_sender_has_to_say_and_the_packets_around_it() -> None:
    frame = Telemetry(5, Mode.PAUSED, 1.0, 2.0, 0.5, 0.1, 1.5, 0, (0, 1), 7 * S, 9 * S)
    sent = pb.Telemetry(
        frame=5, mode="paused", x_m=1, y_m=2, z_m=0.5, heading_rad=0.1, speed_mps=1.5, target=0, reached=[0, 1]
    )
    sent.issued_ns = 7 * S
    assert size_bytes(frame) == 6 + sent.ByteSize()
    assert size_bytes(replace(frame, received_ns=10**15)) == size_bytes(frame)
    seven_letters = size_bytes(replace(frame, mode=Mode.HOLDING))
    assert {size_bytes(replace(frame, mode=mode)) for mode in (Mode.NAVIGATING, Mode.TELEOPERATED)} == {seven_letters}
    command = Command(1, CommandKind.HOLD, (), "", 0, 5)
    empty = pb.Command(id=1, kind="hold", attempt=1, released=-1, target_id=-1, not_before_ns=-1, expires_ns=-1)
    assert size_bytes(command) == 6 + empty.ByteSize()
    assert size_bytes(Snapshot(3, np.zeros(29), 4, 5)) == 6 + 8 * (1 + 29 + 1)


@pytest.mark.parametrize(("data", "size"), [(0, 7), (1, 7), (65_536, 65_542), (65_537, 65_549), (200_000, 200_024)])
def test_large_content_goes_in_several_packets(data: int, size: int) -> None:
    assert packets_bytes(data) == size


def test_messages_go_by_their_kind_and_number() -> None:
    assert named(ACK) == ("ack", 3)
    assert named(Command(9, CommandKind.HOLD, (), "", 0, 5)) == ("command", 9)
    assert named(Snapshot(3, np.zeros(1), 4, 5)) == ("snapshot", 3)
