"""Pictures in the log, as viewers find them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from mcap.reader import make_reader

from tests.log.fake_flight import WAYPOINTS, flight, header
from waypointctl.log.header import LAYOUT_NAME
from waypointctl.log.messages import Message, Picture
from waypointctl.log.png import to_png
from waypointctl.log.reader import open_log
from waypointctl.log.writer import LogWriter

PNG = to_png(np.zeros((4, 4, 3), np.uint8), "north", "a test")
PICTURES = (Picture(1_500_000_000, "camera", "png", PNG), Picture(2_000_000_001, "camera", "png", PNG[::-1]))


def written(path: Path, *more: Message) -> Path:
    with LogWriter(path, header()) as sink:
        for message in (*flight(60), *more):
            sink(message)
    return path


def test_another_reader_finds_an_image_at_its_time(tmp_path: Path) -> None:
    path = written(tmp_path / "flight.mcap", *PICTURES)
    with path.open("rb") as stream:
        found = [(schema, message) for schema, _, message in make_reader(stream).iter_messages(["/camera"])]
    assert [schema.name for schema, _ in found if schema is not None] == ["foxglove.CompressedImage"] * 2
    for (_, message), picture in zip(found, PICTURES, strict=True):
        image = CompressedImage.FromString(message.data)
        assert (message.log_time, message.publish_time) == (picture.time_ns, picture.time_ns)
        assert image.timestamp.ToNanoseconds() == picture.time_ns
        assert (image.frame_id, image.format, image.data) == ("camera", "png", picture.data)


def test_our_reader_gives_them_back_among_the_rest(tmp_path: Path) -> None:
    log = open_log(written(tmp_path / "flight.mcap", *PICTURES))
    assert tuple(log.messages(("/camera",))) == PICTURES
    assert [type(message) for message in log.messages()][-2:] == [Picture, Picture]
    assert log.count("/camera") == 2


def test_a_log_without_pictures_does_not_speak_of_them(tmp_path: Path) -> None:
    path = written(tmp_path / "flight.mcap")
    assert b"CompressedImage" not in path.read_bytes()
    assert "/camera" not in open_log(path).topics
    assert open_log(path).count("/camera") == 0


def test_the_layout_shows_them_where_the_mission_observes(tmp_path: Path) -> None:
    panels = []
    for task in ("", "observe"):
        waypoints = tuple(replace(waypoint, task=task) for waypoint in WAYPOINTS)
        path = tmp_path / f"flight{task}.mcap"
        with LogWriter(path, replace(header(), waypoints=waypoints)):
            pass
        layout = json.loads(open_log(path).attachments[LAYOUT_NAME])
        assert set(layout["configById"]) == set(leaves(layout["layout"]))
        panels.append(layout["configById"])
    assert set(panels[1]) - set(panels[0]) == {"Image!camera"}
    assert panels[1]["Image!camera"] == {"imageMode": {"imageTopic": "/camera"}}


def leaves(node: object) -> list[str]:
    if isinstance(node, dict):
        return [*leaves(node["first"]), *leaves(node["second"])]
    return [str(node)]
