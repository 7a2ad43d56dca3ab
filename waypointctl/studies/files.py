"""What a delay study leaves in its folder."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from waypointctl.paths import write_whole
from waypointctl.studies.delay import DelayStudy
from waypointctl.studies.tables import tables, to_csv, to_markdown

STUDY: Final = "study.json"
TABLES: Final = "tables.md"
VALUES: Final = "cells.csv"
PICTURE: Final = "delay.png"


def write_study(study: DelayStudy, folder: Path) -> None:
    """Write what a study found into its folder: as JSON, as tables, as comma-separated values and as a picture.

    Raises:
        OutputError: a file cannot be written.
    """
    from waypointctl.studies.picture import draw

    write_whole(folder / STUDY, f"{study.model_dump_json(indent=2)}\n".encode(), "the study")
    write_whole(folder / TABLES, to_markdown(tables(study)).encode(), "the tables")
    write_whole(folder / VALUES, to_csv(study).encode(), "the values")
    write_whole(folder / PICTURE, draw(study), "the picture")
