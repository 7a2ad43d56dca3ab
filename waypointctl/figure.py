"""How pictures are made: one style, one set of colours, the same bytes for the same content."""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable
from typing import Any, Final

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from waypointctl.display_text import printable_lines

# Colours that the colour-blind tell apart (Okabe and Ito), and greys.
BLUE: Final = "#0072B2"
GREEN: Final = "#009E73"
VERMILION: Final = "#D55E00"
PURPLE: Final = "#8E44AD"
PINK: Final = "#CC3D7A"
OCHRE: Final = "#B8860B"
RED: Final = "#C00000"
INK: Final = "#222222"
GREY: Final = "#8A8A8A"
FAINT: Final = "#B8B8B8"

_STYLE: Final[dict[Any, Any]] = {
    "text.parse_math": False,  # a dollar sign in somebody's name for something is a dollar sign
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "text.color": INK,
}


def picture(
    draw: Callable[[Figure], object], size_in: tuple[float, float], dpi: int, style: dict[Any, Any] | None = None
) -> bytes:
    """Return a figure as PNG; the same drawing gives the same bytes.

    Args:
        draw: fills the figure.
        size_in: its width and height [in].
        dpi: pixels an inch.
        style: matplotlib's settings that the picture has beside the common ones.
    """
    with mpl.rc_context({**_STYLE, **(style or {})}), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from")  # of a script the font lacks: drawn as a box
        figure = Figure(figsize=size_in, dpi=dpi)
        FigureCanvasAgg(figure)
        draw(figure)
        _escape_texts(figure)
        image = io.BytesIO()
        figure.savefig(image, format="png", dpi=dpi, metadata={"Software": None})
    return image.getvalue()


def _escape_texts(figure: Figure) -> None:
    for text in figure.findobj(Text):
        assert isinstance(text, Text)
        shown = printable_lines(text.get_text())
        if shown != text.get_text():
            text.set_text(shown)
