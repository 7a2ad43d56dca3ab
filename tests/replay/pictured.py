"""A flight with pictures, and ways to change them."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from tests.replay.rewriting import Flown
from waypointctl.flight.fly import fly
from waypointctl.log.messages import Message, Picture
from waypointctl.log.png import SOFTWARE, TITLE, texts_of, to_png
from waypointctl.mission.files import MissionFile, parse_mission
from waypointctl.policy.bundle import LoadedPolicy

SURVEY = b"""\
name: survey
policy: ./policy
seed: 4
defaults: {tolerance: 10 m, observe: true}
waypoints:
  - {name: rock, position: [0.2 m, 0 m]}
  - {name: "../a b/\xc3\xb6", position: [3 m, 1 m]}
link: {delay: 130 ms, jitter: 20 ms}
"""


def fly_survey(folder: Path, policy: LoadedPolicy) -> Flown:
    """Record a flight with two pictures."""
    mission_file = MissionFile(parse_mission(SURVEY, "mission.yaml"), SURVEY, folder / "mission.yaml")
    result = fly(mission_file, policy, log=folder / "flight.mcap", pictures=True)
    assert (result.pictures, result.no_pictures) == (2, "")
    return Flown(mission_file, policy, folder / "flight.mcap")


def with_picture(flown: Flown, number: int, change: Callable[[Picture], list[Message]]) -> list[Message]:
    """Return a flight's messages with others in the place of picture `number`."""
    messages = flown.messages
    at = [index for index, message in enumerate(messages) if isinstance(message, Picture)][number]
    picture = messages[at]
    assert isinstance(picture, Picture)
    return [*messages[:at], *change(picture), *messages[at + 1 :]]


def repainted(picture: Picture, renderer: str | None = None) -> Picture:
    """Return a whole picture with one pixel a little darker, drawn by who is said to have."""
    texts = texts_of(picture.data)
    with Image.open(io.BytesIO(picture.data)) as image:
        pixels = np.array(image)
    pixels[100, 200, 1] -= 1
    return replace(picture, data=to_png(pixels, texts[TITLE], renderer or texts[SOFTWARE]))
