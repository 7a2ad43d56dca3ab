"""A picture's file: the pixels, what it says of itself, and that no bit of it can change unseen."""

from __future__ import annotations

import io
import struct
import zlib

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from waypointctl.log.png import SOFTWARE, TITLE, packer, texts_of, to_png


@pytest.fixture
def pixels() -> NDArray[np.uint8]:
    return np.random.default_rng(1).integers(0, 256, (6, 9, 3), np.uint8)


def test_the_pixels_come_back(pixels: NDArray[np.uint8]) -> None:
    with Image.open(io.BytesIO(to_png(pixels, "", ""))) as image:
        assert (image.format, image.mode, image.size) == ("PNG", "RGB", (9, 6))
        np.testing.assert_array_equal(np.asarray(image), pixels)


def test_it_says_what_it_shows_and_what_drew_it(pixels: NDArray[np.uint8]) -> None:
    texts = texts_of(to_png(pixels, "Höhle \N{ROCKET}", "llvmpipe, OpenGL 4.5"))
    assert texts == {TITLE: "Höhle \N{ROCKET}", SOFTWARE: "llvmpipe, OpenGL 4.5"}


def test_the_same_picture_is_the_same_bytes(pixels: NDArray[np.uint8]) -> None:
    assert to_png(pixels, "a", "b") == to_png(pixels.copy(), "a", "b")
    assert to_png(pixels, "a", "b") != to_png(255 - pixels, "a", "b")


def test_what_packs_it_has_a_version() -> None:
    assert packer().startswith("Pillow ")
    assert packer().count(".") >= 2


def test_every_flipped_bit_is_seen(pixels: NDArray[np.uint8]) -> None:
    data = to_png(pixels[:2, :2], "a rock", "me")
    for at in range(len(data)):
        for bit in range(8):
            flipped = bytearray(data)
            flipped[at] ^= 1 << bit
            with pytest.raises(ValueError, match="PNG"):
                texts_of(bytes(flipped))


@pytest.mark.parametrize("cut", [slice(0), slice(8), slice(-1), slice(-12)])
def test_half_a_file_is_none(pixels: NDArray[np.uint8], cut: slice) -> None:
    with pytest.raises(ValueError, match="is not a complete PNG file"):
        texts_of(to_png(pixels, "", "")[cut])


def test_nothing_may_follow_it(pixels: NDArray[np.uint8]) -> None:
    data = to_png(pixels, "", "")
    for more in (b"more", data):
        with pytest.raises(ValueError, match="PNG"):
            texts_of(data + more)


@pytest.mark.parametrize("side", [12_000, 60_000])
def test_one_that_claims_to_be_enormous_is_damaged(pixels: NDArray[np.uint8], side: int) -> None:
    data = to_png(pixels, "rock", "here")
    header = b"IHDR" + struct.pack(">II", side, side) + data[24:29]
    with pytest.raises(ValueError, match="is a damaged PNG file"):
        texts_of(data[:12] + header + struct.pack(">I", zlib.crc32(header)) + data[33:])
