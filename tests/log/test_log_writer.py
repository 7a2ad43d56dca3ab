"""What stands in the file, and where the file stands."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import SeekingReader
from mcap.records import Attachment as AttachmentRecord
from mcap.records import Chunk, DataEnd, Message, Metadata
from mcap.stream_reader import StreamReader

from tests.log.fake_flight import DOWN_NS, UP_NS, flight, header
from waypointctl import __version__
from waypointctl.errors import OutputError
from waypointctl.log.channels import CHUNK_BYTES
from waypointctl.log.header import SCHEMA_VERSION, Attachment
from waypointctl.log.messages import Checkpoint
from waypointctl.log.reader import open_log
from waypointctl.log.writer import LogWriter

ROOT = Path(__file__).parents[2]
LINK_TOPICS = {"/command": UP_NS, "/ack": DOWN_NS, "/telemetry": DOWN_NS}


def by_topic(path: Path) -> dict[str, list[Message]]:
    found = defaultdict(list)
    with open(path, "rb") as stream:
        for _, channel, message in SeekingReader(stream, validate_crcs=True).iter_messages(log_time_order=False):
            found[channel.topic].append(message)
    return found


def test_two_processes_write_the_same_bytes(tmp_path: Path) -> None:
    hashes = set()
    for name, hash_seed in (("one", "1"), ("two", "2")):
        out = tmp_path / f"{name}.mcap"
        environment = os.environ | {"PYTHONHASHSEED": hash_seed}
        subprocess.run([sys.executable, "-m", "tests.log.fake_flight", out], check=True, env=environment, cwd=ROOT)
        hashes.add(hashlib.sha256(out.read_bytes()).hexdigest())
    assert len(hashes) == 1


def test_attachments_come_first_then_metadata_then_messages(log_path: Path) -> None:
    with open(log_path, "rb") as stream:
        kinds = [type(record) for record in StreamReader(stream, emit_chunks=True, validate_crcs=True).records]
    firsts = [kinds.index(kind) for kind in (AttachmentRecord, Metadata, Chunk, DataEnd)]
    assert firsts == sorted(firsts)
    assert kinds[1:4] == [AttachmentRecord] * 3


def test_library_is_ours_and_attachments_have_no_times(log_path: Path) -> None:
    with open(log_path, "rb") as stream:
        reader = SeekingReader(stream)
        assert reader.get_header().library == f"waypointctl {__version__}"
        attachments = list(reader.iter_attachments())
    assert [it.name for it in attachments] == ["mission.yaml", "model.mjb", "foxglove-layout.json"]
    assert {(it.create_time, it.log_time) for it in attachments} == {(0, 0)}


def test_publish_time_is_when_it_was_issued(log_path: Path) -> None:
    for topic, messages in by_topic(log_path).items():
        delay_ns = LINK_TOPICS.get(topic, 0)
        assert {message.log_time - message.publish_time for message in messages} == {delay_ns}, topic


def test_sequence_numbers_count_each_channel(log_path: Path) -> None:
    for topic, messages in by_topic(log_path).items():
        assert [message.sequence for message in messages] == list(range(len(messages))), topic


def test_every_topic_of_the_contract_is_there_with_its_schema(log_path: Path) -> None:
    assert {name: topic.schema for name, topic in open_log(log_path).topics.items()} == {
        "/state": "waypointctl.State",
        "/observation": "waypointctl.Observation",
        "/action": "waypointctl.Action",
        "/reward": "waypointctl.Reward",
        "/command": "waypointctl.Command",
        "/command_stage": "waypointctl.CommandStage",
        "/ack": "waypointctl.Ack",
        "/telemetry": "waypointctl.Telemetry",
        "/ground_control": "waypointctl.GroundControl",
        "/link": "waypointctl.LinkRecord",
        "/console": "waypointctl.ConsoleInput",
        "/event": "waypointctl.Event",
        "/checkpoint": "waypointctl.Checkpoint",
        "/tf": "foxglove.FrameTransforms",
        "/odometry": "foxglove.Odometry",
        "/joints": "foxglove.JointStates",
        "/scene": "foxglove.SceneUpdate",
        "/goal": "foxglove.SceneUpdate",
        "/waypoints": "foxglove.PosesInFrame",
        "/path": "foxglove.PosesInFrame",
        "/log": "foxglove.Log",
    }


def chunks(path: Path) -> list[Chunk]:
    with open(path, "rb") as stream:
        records = StreamReader(stream, emit_chunks=True).records
        return [record for record in records if isinstance(record, Chunk)]


def test_chunks_are_small_compressed_checked_and_end_with_the_second(log_path: Path) -> None:
    for chunk in chunks(log_path):
        assert chunk.compression == "zstd"
        assert chunk.uncompressed_crc != 0
        assert chunk.uncompressed_size <= CHUNK_BYTES == 256 * 1024
        assert chunk.message_start_time // 10**9 == chunk.message_end_time // 10**9


def test_chunks_stay_small_when_a_second_holds_much(tmp_path: Path) -> None:
    path = tmp_path / "flight.mcap"
    with LogWriter(path, header()) as sink:
        for step in range(100):
            sink(Checkpoint(step, step, np.random.default_rng(step).normal(size=2000), "", ""))
    sizes = [chunk.uncompressed_size for chunk in chunks(path)]
    assert sum(sizes) > 100 * 16_000
    assert max(sizes) <= CHUNK_BYTES


def test_log_has_its_name_only_once_it_is_closed(tmp_path: Path) -> None:
    path = tmp_path / "flight.mcap"
    with LogWriter(path, header()) as sink:
        assert [it.name for it in tmp_path.iterdir()] == ["flight.mcap.part"]
        sink.close()
        assert [it.name for it in tmp_path.iterdir()] == ["flight.mcap"]
    assert open_log(path).is_complete


def test_after_an_exception_the_log_is_whole_but_keeps_its_part_name(tmp_path: Path) -> None:
    messages = list(flight(60))
    with pytest.raises(ZeroDivisionError), LogWriter(tmp_path / "flight.mcap", header()) as sink:  # noqa: PT012
        for message in messages:
            sink(message)
        raise ZeroDivisionError
    assert [it.name for it in tmp_path.iterdir()] == ["flight.mcap.part"]
    log = open_log(tmp_path / "flight.mcap.part")
    assert log.is_complete
    assert len(list(log.messages())) == len(messages)


def test_a_finished_second_is_in_the_file_before_the_next_has_ended(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "flight.mcap", header()) as sink:
        for message in flight(60):
            sink(message)
        on_disk = open_log(tmp_path / "flight.mcap.part", allow_truncated=True)
        assert on_disk.topics["/state"].count == 50


def test_an_earlier_log_stays_until_the_new_one_is_closed(tmp_path: Path) -> None:
    path = tmp_path / "flight.mcap"
    path.write_text("the earlier one")
    with LogWriter(path, header()):
        assert path.read_text() == "the earlier one"
    assert open_log(path).is_complete


def test_schema_version_is_the_writers(tmp_path: Path) -> None:
    path = tmp_path / "flight.mcap"
    LogWriter(path, header(schema_version="99", robot="another")).close()
    metadata = open_log(path).metadata
    assert metadata == {"schema_version": str(SCHEMA_VERSION), "robot": "fake", "seed": "7", "epoch": "mission start"}


def test_layout_names_only_topics_and_frames_that_exist(log_path: Path) -> None:
    log = open_log(log_path)
    layout = json.loads(log.attachments["foxglove-layout.json"])
    panels = layout["configById"]
    plotted = [path["value"] for panel in panels.values() for path in panel.get("paths", [])]
    shown = [*panels["3D!scene"]["topics"], panels["RosOut!log"]["topicToRender"]]
    assert {path.split(".")[0] for path in plotted} | set(shown) <= set(log.topics)
    assert panels["3D!scene"]["followTf"] == "torso"
    assert sorted(leaves(layout["layout"])) == sorted(panels)


def leaves(split: object) -> list[str]:
    if isinstance(split, dict):
        return leaves(split["first"]) + leaves(split["second"])
    return [str(split)]


def test_missing_folder_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "nowhere" / "flight.mcap"
    with pytest.raises(
        OutputError, match=r"nowhere/flight\.mcap: cannot be written: the folder .*nowhere does not exist\n  Create"
    ):
        LogWriter(path, header())


def test_folder_in_the_place_of_the_log_is_refused(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="is a folder; a log is a file"):
        LogWriter(tmp_path, header())
    assert not tmp_path.with_name(f"{tmp_path.name}.part").exists()


def test_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="cannot be written: Not a directory"):
        LogWriter(tmp_path / "file" / "flight.mcap", header())


@pytest.mark.skipif(not os.path.isdir("/proc/self/fd"), reason="needs a list of the open files")
def test_a_writer_that_cannot_begin_leaves_nothing_open(tmp_path: Path) -> None:
    good = header()
    bad = replace(good, attachments=(*good.attachments, Attachment("x", "text/plain", None)))  # type: ignore[arg-type]
    with pytest.raises(TypeError) as caught:
        LogWriter(tmp_path / "flight.mcap", bad)
    part = str(tmp_path / "flight.mcap.part")
    assert os.path.exists(part)
    assert part not in {os.path.realpath(f"/proc/self/fd/{number}") for number in os.listdir("/proc/self/fd")}
    assert caught.tb  # whose frames keep the writer: it is not the collector that has closed the file


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is always full")
def test_full_disk_is_said_once_and_clearly(tmp_path: Path) -> None:
    (tmp_path / "flight.mcap.part").symlink_to("/dev/full")
    with pytest.raises(OutputError, match=r"cannot be written: No space left on device\n  Make room on the disk"):
        LogWriter(tmp_path / "flight.mcap", header())
