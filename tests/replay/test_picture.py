from __future__ import annotations

import io
import struct
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.image import imread

from tests.replay.hand_made import FAR, NEAR, event, flight
from waypointctl.log.messages import Clock, EventKind, Message
from waypointctl.replay.picture.page import HEIGHT, WIDTH, _moving_mean, draw
from waypointctl.replay.summary_builder import summarize
from waypointctl.replay.track import Track
from waypointctl.units import NS_PER_S

SENT = event(0, EventKind.COMMAND_SENT, "command 1 sent: go_to near", Clock.OPERATOR, command_id=1)
CURIOUS = replace(NEAR, name=r"$\frac{[red]")
FOREIGN = replace(NEAR, name="近い")


def picture_of(messages: Iterable[Message]) -> bytes:
    return draw(summarize(messages, (NEAR, FAR)), "hand", "replay exact, 10 control steps", is_exact=True)


def test_the_picture_is_a_png_of_its_size_and_of_its_flight() -> None:
    png = picture_of(flight())
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", png[16:24]) == (WIDTH, HEIGHT)
    assert picture_of(flight()) == png
    assert picture_of(list(flight())[:-8]) != png


@pytest.mark.parametrize("messages", [[], [SENT], list(flight())[:20]], ids=["nothing", "under way", "half"])
def test_an_unfinished_story_can_be_drawn(messages: list[Message]) -> None:
    assert picture_of(messages).startswith(b"\x89PNG")


def test_names_are_drawn_as_they_are_and_of_many_waypoints_too() -> None:
    many = [CURIOUS, FOREIGN, *(replace(NEAR, index=n, name=f"WP{n}", x_m=float(n)) for n in range(2, 60))]
    assert draw(summarize(flight(), many), "a $ and a {", "", is_exact=True).startswith(b"\x89PNG")


def red_pixels_at_the_top(png: bytes) -> int:
    image = imread(io.BytesIO(png), format="png")[:80, :, :3]
    red, green, blue = np.moveaxis(image, 2, 0)
    return int(np.count_nonzero((red > 0.6) & (green < 0.2) & (blue < 0.2)))


def test_a_flight_that_did_not_happen_again_says_so_at_the_top_in_red() -> None:
    summary = summarize(flight(), (NEAR, FAR))
    proof = "replay diverged, 10 control steps"
    assert red_pixels_at_the_top(draw(summary, "hand", proof, is_exact=False)) > 1000
    assert red_pixels_at_the_top(draw(summary, "hand", proof, is_exact=True)) == 0


def test_moving_mean_by_hand() -> None:
    times = np.arange(5) * NS_PER_S // 5  # 0.2 s apart: half a second around a row holds it and its neighbours
    speeds = np.array([0.0, 3.0, 6.0, 9.0, 0.0])
    track = Track(times, times, speeds, speeds, speeds)
    np.testing.assert_allclose(_moving_mean(track), [1.5, 3.0, 6.0, 5.0, 4.5])
