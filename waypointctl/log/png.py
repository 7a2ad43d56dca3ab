"""Pictures as PNG files; text chunks name the waypoint and the software, and image viewers display them."""

from __future__ import annotations

import io
import warnings
from importlib.metadata import version
from typing import Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image, features
from PIL.PngImagePlugin import PngInfo

TITLE: Final = "Title"  # the waypoint's name; a PNG's own keyword, as is the next one
SOFTWARE: Final = "Software"  # what drew the picture and packed it: where it is the same, the bytes are
_LEVEL: Final = 6  # zlib's; named, because Pillow's own choice may change with its version
_END: Final = b"\0\0\0\0IEND\xaeB`\x82"


def packer() -> str:
    """Return what makes the file's bytes, beside the pixels."""
    name = "zlib_ng" if features.check("zlib_ng") else "zlib"
    return f"Pillow {version('pillow')}, {name} {features.version(name)}"


def to_png(pixels: NDArray[np.uint8], title: str, software: str) -> bytes:
    """Return a picture (height, width, 3), red green blue, the first row on top, as a PNG file."""
    texts = PngInfo()
    texts.add_itxt(TITLE, title)  # itxt is Unicode; the older text chunk is not
    texts.add_itxt(SOFTWARE, software)
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "png", pnginfo=texts, compress_level=_LEVEL)
    return file.getvalue()


def texts_of(data: bytes) -> dict[str, str]:
    """Return the text chunks of a PNG file, after checking every checksum.

    Raises:
        ValueError: it is none, or is damaged.
    """
    if data.find(_END) != len(data) - len(_END):
        raise ValueError("is not a complete PNG file")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            image = Image.open(io.BytesIO(data), formats=["png"])
        with image:
            texts = {str(key): str(text) for key, text in image.info.items() if isinstance(text, str)}
            image.verify()
    # Pillow raises SyntaxError for a broken chunk, OSError for other files, and its own for one too large.
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError, Image.DecompressionBombWarning) as error:
        raise ValueError(f"is a damaged PNG file: {error}") from error
    return texts
