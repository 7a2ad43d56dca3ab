"""A flight over a link that has everything, and the files that say so: replayed from the log alone."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.replay.rewriting import Flown, altered
from waypointctl.flight.fly import fly
from waypointctl.log.messages import Ack, Checkpoint, Command, DeliveryOutcome, LinkRecord, Telemetry
from waypointctl.log.reader import open_log
from waypointctl.mission.files import load_mission
from waypointctl.policy.bundle import LoadedPolicy
from waypointctl.replay.verify import Verdict, verify

PLAN = b"""\
a contact +0 +2 1 2 500
a contact +3 +30 1 2 500
a contact +0 +30 2 1 300
a range +0 +30 1 2 0.1
"""
JITTER = b"# measured\n0.0\n0.004\n0.031\n"
MISSION = """\
name: through
policy: ./policy
seed: 9
waypoints:
  - {name: here, position: [0.2 m, 0 m], tolerance: 10 m, hold: 2 s}
  - {name: far, position: [90 m, 0 m], timeout: 2 s}
telemetry: {rate: 20 Hz}
link:
  up: {contact_plan: {file: plans/site.ionrc, from_node: 1, to_node: 2}, jitter_file: jitter.txt}
  down:
    contact_plan: {file: plans/site.ionrc, from_node: 2, to_node: 1}
    jitter_file: jitter.txt
    loss: {p: 5 %, r: 40 %, one_minus_k: 1 %}
    duplicate: 10 %
    queue: 600 B
    keep_order: false
expect: {max_time: 6 s}
"""


@pytest.fixture(scope="module")
def through(tmp_path_factory: pytest.TempPathFactory, make_policy: Callable[..., LoadedPolicy]) -> Flown:
    folder: Path = tmp_path_factory.mktemp("through")
    (folder / "plans").mkdir()
    (folder / "plans" / "site.ionrc").write_bytes(PLAN)
    (folder / "jitter.txt").write_bytes(JITTER)
    (folder / "mission.yaml").write_text(MISSION)
    mission_file, policy = load_mission(folder / "mission.yaml"), make_policy(folder / "policy", seed=7)
    fly(mission_file, policy, log=folder / "flight.mcap")
    for each in ("plans/site.ionrc", "jitter.txt"):
        (folder / each).unlink()  # the log has to do without them
    return Flown(mission_file, policy, folder / "flight.mcap")


def test_the_flight_is_replayed_bit_for_bit_from_the_log_alone(through: Flown) -> None:
    result = verify(through.path)
    assert (result.verdict, result.first_divergence) == (Verdict.EXACT, None)


def test_the_log_carries_the_files_with_their_hashes(through: Flown) -> None:
    log = open_log(through.path)
    for name, content in (("plans/site.ionrc", PLAN), ("jitter.txt", JITTER)):
        assert log.attachments[f"mission/{name}"] == content
        assert log.metadata[f"sha256_mission/{name}"] == hashlib.sha256(content).hexdigest()


def test_the_log_tells_of_all_that_was_lost_doubled_or_had_to_wait(through: Flown) -> None:
    messages = through.messages
    records = [message for message in messages if isinstance(message, LinkRecord)]
    assert {each.outcome for each in records} >= {
        DeliveryOutcome.LOST,
        DeliveryOutcome.DUPLICATED,
        DeliveryOutcome.QUEUED,
        DeliveryOutcome.QUEUE_FULL,
    }
    heard = [message.frame for message in messages if isinstance(message, Telemetry)]
    frames = {each.number: each for each in records if each.message == "telemetry"}
    end_ns = max(message.received_ns for message in messages if isinstance(message, Telemetry | Ack | Command))
    for number, each in frames.items():
        assert heard.count(number) == sum(arrives_ns <= end_ns for arrives_ns in each.arrives_ns), each
    silent = {number for number in range(max(heard)) if number not in heard}
    assert silent <= frames.keys(), "what never came has its record"
    assert {number for number in heard if heard.count(number) > 1} <= frames.keys()


def test_a_replay_parts_where_the_link_was_altered(through: Flown, tmp_path: Path) -> None:
    messages = through.messages
    at = next(i for i, message in enumerate(messages) if isinstance(message, LinkRecord))
    changed = [*messages[:at], altered(messages[at], "size_bytes"), *messages[at + 1 :]]
    result = verify(through.rewritten(tmp_path / "size.mcap", changed))
    assert result.first_divergence is not None
    assert (result.first_divergence.topic, result.first_divergence.component) == ("/link", "size_bytes")
    at = max(i for i, message in enumerate(messages) if isinstance(message, Checkpoint))
    state = altered(messages[at], "link")
    result = verify(through.rewritten(tmp_path / "state.mcap", [*messages[:at], state, *messages[at + 1 :]]))
    assert result.first_divergence is not None
    assert (result.first_divergence.topic, result.first_divergence.component) == ("/checkpoint", "link")


@pytest.mark.parametrize("content", [PLAN.replace(b"0.1", b"0.2"), None])
def test_a_file_that_was_altered_or_left_out_is_found_before_the_flight(
    through: Flown, tmp_path: Path, content: bytes | None
) -> None:
    result = verify(through.rewritten(tmp_path / "plan.mcap", attachments={"mission/plans/site.ionrc": content}))
    assert result.verdict is Verdict.DIVERGED
    assert result.first_divergence is not None
    assert (result.first_divergence.topic, result.first_divergence.component) == (
        "attachment",
        "mission/plans/site.ionrc",
    )


def test_a_file_that_nobody_vouches_for_is_found(through: Flown, tmp_path: Path) -> None:
    metadata = {"sha256_mission/jitter.txt": "0" * 64}
    result = verify(through.rewritten(tmp_path / "hash.mcap", metadata=metadata))
    assert result.first_divergence is not None
    assert result.first_divergence.component == "mission/jitter.txt"
