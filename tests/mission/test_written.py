from __future__ import annotations

import pytest

from waypointctl.mission.yaml_source import written_at
from waypointctl.mission.yaml_tree import DataPath, read_tree

TEXT = b"""\
name: n
link:
  rate: 3 bit/s
  down:
    loss: 0.1
waypoints:
  - [1, 2]
  - {position: [1 m, 2 m], timeout_s: 3}
"""


@pytest.mark.parametrize(
    ("path", "written", "place"),
    [
        (("name",), "name", (1, 1)),
        (("link", "up", "rate_bps"), "link.rate", (3, 3)),
        (("link", "down", "loss"), "link.down.loss", (5, 5)),
        (("waypoints", 1, "timeout_s"), "waypoints[1].timeout_s", (8, 28)),
        (("waypoints", 0, "timeout_s"), "waypoints[0]", (7, 5)),
        (("onboard", "link_loss"), "onboard.link_loss", (1, 1)),
        (("link", "up", "windows"), "link", (2, 1)),
        (("expect", "max_time_s"), "expect.max_time", (1, 1)),
    ],
)
def test_a_place_in_the_model_is_one_in_the_file(path: DataPath, written: str, place: tuple[int, int]) -> None:
    text, mark = written_at(read_tree(TEXT), path)
    assert (text, (mark.line, mark.column)) == (written, place)
