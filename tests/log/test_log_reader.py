"""What a log answers when it is asked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.log.fake_flight import STEP_NS, UP_NS, bits, flight, header
from waypointctl.errors import LogError
from waypointctl.log.messages import Ack, Command, Message, Reward, State
from waypointctl.log.reader import open_log
from waypointctl.log.topics import BY_KIND
from waypointctl.log.writer import LogWriter
from waypointctl.units import NS_PER_S


def log_time_ns(message: Message) -> int:
    return BY_KIND[type(message)].times_ns(message)[0]


def test_messages_come_in_the_order_they_were_written(log_path: Path) -> None:
    assert [bits(message) for message in open_log(log_path).messages()] == [bits(message) for message in flight()]


def test_topics_choose(log_path: Path) -> None:
    read = list(open_log(log_path).messages(topics=["/reward", "/command"]))
    expected = [message for message in flight() if isinstance(message, Reward | Command)]
    assert [bits(message) for message in read] == [bits(message) for message in expected]


@pytest.mark.parametrize(
    ("start_ns", "end_ns"),
    [(None, NS_PER_S), (NS_PER_S, None), (UP_NS, UP_NS + 1), (1_230_000_000, 2_990_000_001), (3, 3), (10**12, None)],
)
def test_times_choose_from_start_up_to_but_not_end(log_path: Path, start_ns: int | None, end_ns: int | None) -> None:
    read = list(open_log(log_path).messages(start_ns=start_ns, end_ns=end_ns))
    lowest, highest = start_ns or 0, 10**15 if end_ns is None else end_ns
    expected = [message for message in flight() if lowest <= log_time_ns(message) < highest]
    assert [bits(message) for message in read] == [bits(message) for message in expected]


@pytest.mark.parametrize("topic", ["/tf", "/states", ""])
def test_topic_without_messages_is_refused_at_once(log_path: Path, topic: str) -> None:
    with pytest.raises(LogError, match=r"no messages are read from the topic .*; allowed are /state, /observation"):
        open_log(log_path).messages(topics=[topic])


def test_statistics(log_path: Path) -> None:
    log = open_log(log_path)
    states = [message.time_ns for message in flight() if isinstance(message, State)]
    topic = log.topics["/state"]
    assert (topic.count, topic.first_ns, topic.last_ns) == (len(states), states[0], states[-1])
    assert topic.rate_hz == pytest.approx(50.0)
    assert log.topics["/command"].rate_hz is None
    assert (log.start_ns, log.end_ns, log.duration_s) == (0, 200 * STEP_NS, 4.0)
    assert log.message_count == sum(topic.count for topic in log.topics.values())


def test_log_without_messages(tmp_path: Path) -> None:
    path = tmp_path / "flight.mcap"
    LogWriter(path, header()).close()
    log = open_log(path)
    assert list(log.messages()) == []
    assert log.topics["/state"].count == 0
    assert log.topics["/state"].first_ns is None


def test_attachments_come_back(log_path: Path) -> None:
    expected = {it.name: it.data for it in header().attachments}
    assert expected.items() <= open_log(log_path).attachments.items()


@pytest.mark.parametrize("shift", [(0, 1), (1, 0)], ids=["log_time", "publish_time"])
def test_a_message_under_other_times_than_its_own_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, shift: tuple[int, int]
) -> None:
    def shifted(ack: Ack) -> tuple[int, int]:
        return ack.received_ns + shift[0], ack.issued_ns + shift[1]

    path = tmp_path / "shifted.mcap"
    with monkeypatch.context() as patch:
        patch.setitem(BY_KIND, Ack, replace(BY_KIND[Ack], times_ns=shifted))
        with LogWriter(path, header()) as writer:
            for message in flight():
                writer(message)
    with pytest.raises(LogError, match="a message on /ack has other times in the file than in itself"):
        list(open_log(path).messages())


def test_a_topic_as_columns(log_path: Path) -> None:
    states = [message for message in flight() if isinstance(message, State)]
    with open_log(log_path) as log:
        columns, rewards, commands = (log.arrays(topic) for topic in ("/state", "/reward", "/command"))
    assert columns["time_ns"].tolist() == [state.time_ns for state in states]
    assert columns["qpos"].shape == (len(states), len(states[0].qpos))
    np.testing.assert_array_equal(columns["qpos"][3], states[3].qpos)
    (terms,) = {tuple(name for name, _ in it.terms) for it in flight() if isinstance(it, Reward)}
    assert {"total", *terms} <= rewards.keys()
    assert commands["kind"].tolist() == [str(it.kind) for it in flight() if isinstance(it, Command)]
    assert "waypoints" not in commands


def test_columns_of_a_topic_that_holds_no_messages_are_refused(log_path: Path) -> None:
    with pytest.raises(LogError, match="no messages are read"):
        open_log(log_path).arrays("/tf")
