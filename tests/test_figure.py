"""The one way in which pictures are made."""

from __future__ import annotations

import io
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

import waypointctl
from waypointctl.figure import BLUE, picture


def disc(figure: Figure) -> None:
    figure.add_axes((0.0, 0.0, 1.0, 1.0)).set_facecolor(BLUE)


def test_it_is_a_png_of_the_size_with_what_was_drawn_and_the_same_each_time() -> None:
    made = picture(disc, (2.0, 1.0), 50)
    pixels = imread(io.BytesIO(made), format="png")
    assert pixels.shape[:2] == (50, 100)
    assert (np.round(pixels[25, 50, :3] * 255) == (0x00, 0x72, 0xB2)).all()
    assert made == picture(disc, (2.0, 1.0), 50)


@pytest.mark.parametrize("text", ["近い", r"$\frac{", "a $5$ b"])
def test_any_name_is_drawn_as_it_is(text: str) -> None:
    plain = picture(lambda figure: None, (2.0, 1.0), 50)
    assert picture(lambda figure: figure.text(0.1, 0.5, text), (2.0, 1.0), 50) not in (plain, b"")


def test_settings_of_its_own_hold_for_it_alone() -> None:
    before = dict(mpl.rcParams)
    found = []
    picture(lambda figure: found.append(mpl.rcParams["font.size"]), (1.0, 1.0), 50, {"font.size": 17.0})
    assert found == [17.0]
    assert dict(mpl.rcParams) == before


def test_no_other_module_sets_matplotlib_up() -> None:
    package = Path(waypointctl.__file__).parent
    users = [path.name for path in package.rglob("*.py") if "FigureCanvasAgg" in path.read_text(encoding="utf-8")]
    assert users == ["figure.py"]
